#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>

#include "base/units.h"
#include "sim/internal/contacts.h"
#include "sim/scene_files.h"
#include "sim/surfaces.h"
#include "sim/world.h"

namespace rangegrasp::sim {
namespace {

constexpr double kHalf_m = 0.02;

// A flat box on the slope, so that it slides and does not tip.
World OnSlope(double tilt_rad) {
  World world(
      samples::PlaneScene(tilt_rad),
      {samples::MakeObject("brick", R"(<geom type="box" size="0.06 0.06 0.02" mass="0.5"/>)")}, {});
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  world.PlaceObject(0, base::MakePose(R, R * Eigen::Vector3d(0, 0, kHalf_m)));
  return world;
}

double Downhill(const World& world, double tilt_rad) {
  return world.ObjectPose(0).translation().dot(
      Eigen::Vector3d(std::cos(tilt_rad), 0, -std::sin(tilt_rad)));
}

double SlideIn(double seconds, double tilt_rad) {
  World world = OnSlope(tilt_rad);
  while (world.time_s() < seconds) world.Step();
  return Downhill(world, tilt_rad);
}

TEST(Incline, SlidesAboveCoulombsAngleAndNotBelow) {
  const double mu =
      FindSurface(ReadSurfaces(ShippedSurfaces()), "cardboard").on_laminate.kinetic_mu;
  const double critical = std::atan(mu);
  EXPECT_LT(SlideIn(1.0, critical - base::Deg(1.0)), 1e-4);
  for (const double above : {1.0, 5.0, 15.0}) {
    const double tilt = critical + base::Deg(above);
    const double acceleration = base::kGravity * (std::sin(tilt) - mu * std::cos(tilt));
    // Contacts need a few steps to load: part of the first hundredths of a second.
    EXPECT_NEAR(SlideIn(1.0, tilt), 0.5 * acceleration, 0.03 * acceleration + 0.002) << above;
  }
}

// Between the kinetic and the static friction angle, a box at rest stays and a pushed box keeps
// sliding.
TEST(Incline, SlipSwitchesFromStaticToKinetic) {
  const FrictionPair pair{0.6, 0.5};
  const double tilt = 0.5 * (std::atan(pair.static_mu) + std::atan(pair.kinetic_mu));
  for (const double push_m_s : {0.0, 0.05}) {
    World world = OnSlope(tilt);
    SlipState slip;
    const int geom = world.model()->body_geomadr[world.object_body(0)];
    world.model()->geom_friction[3 * geom] = 2.0;  // until it is at rest on the slope
    while (world.time_s() < 0.3) world.Step();
    const double start = Downhill(world, tilt);
    world.data()->qvel[0] = push_m_s * std::cos(tilt);
    world.data()->qvel[2] = -push_m_s * std::sin(tilt);
    while (world.time_s() < 1.3) {
      double speed = -1.0;
      for (int i = 0; i < world.data()->ncon; ++i) {
        speed = std::max(
            speed, internal::SlipSpeed(world.model(), world.data(), world.data()->contact[i]));
      }
      slip.Update(speed);
      world.model()->geom_friction[3 * geom] = slip.Coefficient(pair);
      world.Step();
    }
    const double acceleration =
        base::kGravity * (std::sin(tilt) - pair.kinetic_mu * std::cos(tilt));
    const double slide = push_m_s > 0 ? push_m_s + 0.5 * acceleration : 0.0;
    // The net acceleration is a tenth of each of its terms, so 1 % of friction is 10 % of it.
    EXPECT_NEAR(Downhill(world, tilt) - start, slide, 0.1 * slide + 1e-4) << push_m_s;
  }
}

}  // namespace
}  // namespace rangegrasp::sim
