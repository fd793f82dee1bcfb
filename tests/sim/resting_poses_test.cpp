#include "sim/resting_poses.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using samples::MakeObject;

// The search for the tipping angle uses steps of half a degree.
constexpr double kTilt = 0.5 * base::kPi / 180.0;

// A box of 2a x 2b x 2c rests on three pairs of faces. On the face 2a x 2b, with height c, it tips
// over the nearer edge at atan(min(a, b) / c). The solid angle of a face from the centre is
// 4 asin(ab / sqrt((a^2+c^2)(b^2+c^2))).
TEST(StableRestingPoses, BoxIsAnalytic) {
  const double a = 0.05, b = 0.03, c = 0.02;
  const auto poses = StableRestingPoses(
      MakeObject("box", R"(<geom type="box" size="0.05 0.03 0.02" mass="0.4"/>)"));
  ASSERT_EQ(poses.size(), 3u);
  const double height[] = {c, b, a};
  const double tipping[] = {std::atan(b / c), std::atan(c / b), std::atan(c / a)};
  const auto solid = [](double x, double y, double z) {
    return 4 * std::asin(x * y / std::sqrt((x * x + z * z) * (y * y + z * z)));
  };
  const double share[] = {solid(a, b, c), solid(a, c, b), solid(b, c, a)};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(poses[i].faces[0].height_m, height[i], 1e-6);
    EXPECT_NEAR(poses[i].tipping_rad, tipping[i], kTilt);
    EXPECT_NEAR(poses[i].probability, 2 * share[i] / (4 * base::kPi), 1e-6);
    EXPECT_EQ(poses[i].label, "pose" + std::to_string(i));
  }
}

// Upright, it tips over the rim at atan(r / h). Lying, it rolls, which does not count as tipping,
// and tips up over the rim at atan(h / r).
TEST(StableRestingPoses, CylinderStandsAndLies) {
  const double r = 0.035, h = 0.06;
  const auto poses = StableRestingPoses(
      MakeObject("tube", R"(<geom type="cylinder" size="0.035 0.06" mass="0.4"/>)"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[0].faces[0].height_m, r, 1e-4);
  EXPECT_NEAR(poses[0].tipping_rad, std::atan(h / r), 2 * kTilt);
  EXPECT_NEAR(poses[1].faces[0].height_m, h, 1e-6);
  EXPECT_NEAR(poses[1].tipping_rad, std::atan(r / h), 2 * kTilt);
  // The caps' solid angle from the centre is 2 * 2 pi (1 - cos).
  EXPECT_NEAR(poses[1].probability, 1 - h / std::hypot(h, r), 2e-3);
}

TEST(StableRestingPoses, ThinPlateDoesNotStandOnItsEdge) {
  const auto poses = StableRestingPoses(
      MakeObject("plate", R"(<geom type="box" size="0.05 0.05 0.005" mass="0.1"/>)"));
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_NEAR(poses[0].faces[0].height_m, 0.005, 1e-6);
  EXPECT_NEAR(poses[0].probability, 1.0, 1e-12);
}

// A leaning column (its top is shifted by its height) falls from its ends onto its long sides. So
// the sides have all the probability except that of the flanks, which is the share of directions
// that leave through a flank.
TEST(StableRestingPoses, WhatFallsCountsForWhereItComesToRest) {
  const std::string file =
      samples::WriteFile("leaning.xml", R"(<mujoco><asset><mesh name="m" vertex="
    -0.07 -0.02 -0.05  -0.03 -0.02 -0.05  -0.07 0.02 -0.05  -0.03 0.02 -0.05
     0.03 -0.02  0.05   0.07 -0.02  0.05   0.03 0.02  0.05   0.07 0.02  0.05"/></asset>
    <worldbody><body name="leaning"><freejoint/><geom type="mesh" mesh="m" mass="0.2"/></body></worldbody></mujoco>)");
  const auto poses = StableRestingPoses({"leaning", file});
  double flank = 0.0;
  int rays = 0;
  for (double z = -0.995; z < 1.0; z += 0.01) {
    for (double angle = 0.005; angle < 2 * base::kPi; angle += 0.01, ++rays) {
      const Eigen::Vector3d d(std::sqrt(1 - z * z) * std::cos(angle),
                              std::sqrt(1 - z * z) * std::sin(angle), z);
      const double through_flank = std::abs(d.y()) / 0.02;
      flank +=
          through_flank > std::abs(d.x() - d.z()) / 0.02 && through_flank > std::abs(d.z()) / 0.05;
    }
  }
  flank /= rays;
  // The flanks are mirror images: no rotation maps one onto the other.
  ASSERT_EQ(poses.size(), 3u);
  double on_flank = 0.0;
  for (const RestingPose& pose : poses) {
    if (std::abs(pose.faces[0].height_m - 0.02) < 1e-4) on_flank += pose.probability;
  }
  EXPECT_NEAR(on_flank, flank, 0.005);
}

// The origin is not the centre; heights refer to the origin.
TEST(StableRestingPoses, HeightIsTheOrigins) {
  const auto poses = StableRestingPoses(
      MakeObject("off", R"(<geom type="box" size="0.05 0.05 0.005" pos="0 0 0.1" mass="0.1"/>)"));
  ASSERT_EQ(poses.size(), 1u);  // both faces are one pose
  const double z = (poses[0].faces[0].R_WO * Eigen::Vector3d(0, 0, 0.1)).z();
  EXPECT_NEAR(poses[0].faces[0].height_m + z, 0.005, 1e-6);
}

// An isosceles prism, 100 mm long along y.
std::vector<RestingPose> PosesOfPrism(const char* center) {
  const std::string file = samples::WriteFile("prism.xml", fmt::format(R"(<mujoco><asset>
    <mesh name="m" vertex="-0.02 -0.05 0  0.02 -0.05 0  0 -0.05 0.03
                           -0.02  0.05 0  0.02  0.05 0  0  0.05 0.03"/></asset>
    <worldbody><body name="prism"><freejoint/>
      <inertial mass="0.2" pos="{}" diaginertia="1e-4 1e-4 1e-4"/>
      <geom type="mesh" mesh="m"/></body></worldbody></mujoco>)",
                                                                       center));
  return StableRestingPoses({"prism", file});
}

std::size_t Faces(const std::vector<RestingPose>& poses) {
  std::size_t faces = 0;
  for (const RestingPose& pose : poses) faces += pose.faces.size();
  return faces;
}

// Half a turn maps one leg onto the other, and one end onto the other, unless the center of mass is
// off the middle. Then the legs are as high as before, but are two poses.
TEST(StableRestingPoses, OnlyATurnOfTheBodyMakesTwoFacesOnePose) {
  const auto even = PosesOfPrism("0 0 0.01");
  const auto uneven = PosesOfPrism("0 0.01 0.01");
  EXPECT_EQ(Faces(even), 5u);
  EXPECT_EQ(Faces(uneven), 5u);
  EXPECT_EQ(even.size(), 3u);  // base, legs, ends
  EXPECT_EQ(uneven.size(), 5u);
}

// A cylinder lies at any roll angle, stands only upright, and leaning is no resting pose.
TEST(FaceAtRest, TellsHowAnObjectRests) {
  const auto poses = StableRestingPoses(
      MakeObject("tube", R"(<geom type="cylinder" size="0.035 0.06" mass="0.4"/>)"));
  const auto label = [&](const Eigen::AngleAxisd& turn) {
    const auto rest = FaceAtRest(poses, turn.toRotationMatrix());
    return rest ? rest->pose->label : "none";
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  EXPECT_EQ(label({0.0, x}), "pose1");
  EXPECT_EQ(label({base::kPi, x}), "pose1");
  EXPECT_EQ(label({base::Deg(20.0), x}), "none");
  for (int i = 0; i < 100; ++i) {
    const Eigen::AngleAxisd roll(0.0628 * i, Eigen::Vector3d::UnitZ());
    const Eigen::Matrix3d R = Eigen::AngleAxisd(base::kPi / 2, x).toRotationMatrix() * roll;
    const auto rest = FaceAtRest(poses, R);
    ASSERT_TRUE(rest) << i;
    EXPECT_EQ(rest->pose->label, "pose0") << i;
    // The face is the one that points down, not another face of the pose.
    const Eigen::Vector3d down_O = rest->face->R_WO.conjugate() * -Eigen::Vector3d::UnitZ();
    EXPECT_GT((R * down_O).dot(-Eigen::Vector3d::UnitZ()), std::cos(base::Deg(5.0))) << i;
  }
}

}  // namespace
}  // namespace rangegrasp::sim
