#include "parts/cloud/revolution.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "parts/cloud/cloud_samples.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

/// Even faces of a cone about z, of slope 1 in 4, seen over half a turn, and a fin that stands off
/// it in a plane beside the axis with a sixth of the area, all moved.
FaceFrames HalfConeWithFin(const Eigen::Isometry3d& move, double noise) {
  base::Rng rng(5);
  FaceFrames frames;
  for (int k = 0; k < 1200; ++k) {
    Vector3d p, n;
    if (k % 6 == 0) {
      p = {0.3, rng.Uniform(1.0, 2.0), rng.Uniform(-1.0, 1.0)};
      n = Vector3d::UnitX();
    } else {
      const double angle = rng.Uniform(0.0, std::numbers::pi);
      const double z = rng.Uniform(-2.0, 2.0);
      const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
      p = (1.0 - 0.25 * z) * out + z * Vector3d::UnitZ();
      n = (out + 0.25 * Vector3d::UnitZ()).normalized();
    }
    frames.center.push_back(move * p);
    frames.normal.push_back((move.linear() * samples::Noisy(n, noise, rng)).normalized());
    frames.area.push_back(1.0);
    frames.total_area += 1.0;
  }
  return frames;
}

TEST(Revolution, TheAxisOfAHalfSeenConeIsFoundBesideAFin) {
  const Eigen::Isometry3d move = Eigen::Translation3d(3.0, -2.0, 5.0) *
                                 Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized());
  for (const double noise : {0.0, 0.1}) {
    const auto axis = FindRevolution(HalfConeWithFin(move, noise));
    ASSERT_TRUE(axis);
    // 1000 normals tilted by 0.1 rad tell the axis to some 0.1 / sqrt(1000); ten times that.
    EXPECT_GT(std::abs(axis->direction.dot(move.linear().col(2))), std::cos(0.03));
    EXPECT_LT(axis->direction.cross(move.translation() - axis->point).norm(), 0.03);
    // The cone's share; the fin's normals meet the axis nowhere.
    EXPECT_NEAR(axis->share, 5.0 / 6.0, 0.02);
  }
}

TEST(Revolution, TwistIsTheSineOfANormalsWayPastTheAxis) {
  const RevolutionAxis axis{{1.0, 0.0, 0.0}, Vector3d::UnitZ(), 1.0};
  const Vector3d p(3.0, 0.0, 7.0);
  EXPECT_NEAR(axis.Twist(p, Vector3d::UnitX()), 0.0, 1e-12);
  EXPECT_NEAR(axis.Twist(p, Vector3d::UnitZ()), 0.0, 1e-12);
  EXPECT_NEAR(axis.Twist(p, Vector3d(std::cos(0.3), std::sin(0.3), 0.0)), std::sin(0.3), 1e-12);
  EXPECT_NEAR(axis.ProfileOf(p).x(), 2.0, 1e-12);
  EXPECT_NEAR(axis.ProfileOf(p).y(), 7.0, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::parts
