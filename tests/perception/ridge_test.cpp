#include "perception/internal/ridge.h"

#include <gtest/gtest.h>

#include <numeric>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using testing::Analytic;

const geometry::Plane kTable{Vector3d::UnitZ(), 0.0};

std::optional<Ridge> RidgeOf(const Analytic& shape) {
  geometry::Indices all(shape.cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  return FindRidge(shape.cloud, all, kTable, {});
}

/// A strip of a lying elliptic cylinder about `axis` through `center`, normals from `from` to `to`
/// about the vertical; half width a, half height b.
Analytic Lying(const Vector3d& center, double yaw_rad, double a, double b, double from_rad,
               double to_rad) {
  Analytic shape;
  const Vector3d axis(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
  const Vector3d lateral(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  for (int row = -25; row <= 25; ++row) {
    for (int k = 0; k <= 60; ++k) {
      const double t = from_rad + (to_rad - from_rad) * k / 60;
      shape.Add(center + 0.002 * row * axis + a * std::sin(t) * lateral +
                    b * std::cos(t) * Vector3d::UnitZ(),
                b * std::sin(t) * lateral + a * std::cos(t) * Vector3d::UnitZ());
    }
  }
  return shape;
}

TEST(FindRidge, IsTheHighestLineOfALyingCylinderSeenFromAnySide) {
  core::Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const double radius = rng.Uniform(0.02, 0.05);
    const double yaw = rng.Uniform(0.0, 2.0 * core::kPi);
    const double x = rng.Uniform(-0.1, 0.1);
    const Vector3d center(x, rng.Uniform(-0.1, 0.1), radius);
    // A sensor at 35 to 50 deg does not see the far side's lower part.
    const double far = rng.Uniform(0.6, 0.9);
    const auto ridge = RidgeOf(Lying(center, yaw, radius, radius, -1.1, far));
    ASSERT_TRUE(ridge) << i;
    const Vector3d axis(std::cos(yaw), std::sin(yaw), 0.0);
    EXPECT_NEAR(std::abs(ridge->axis.dot(axis)), 1.0, 1e-9);
    EXPECT_NEAR(ridge->normal.z(), 1.0, 1e-9);
    EXPECT_NEAR((ridge->point - center).cross(axis).dot(Vector3d::UnitZ()), 0.0, 1e-9);
    // The height is the 80 % quantile of the strip's: at 0.35 / 5 rad from the ridge, to a step of
    // the sampling (2 rad / 60).
    EXPECT_LE(ridge->point.z(), 2.0 * radius);
    EXPECT_GE(ridge->point.z(), radius + radius * std::cos(0.07 + 0.034));
  }
}

TEST(FindRidge, IsTheFoldOfAFlatRoof) {
  Analytic roof;
  const double c = std::cos(core::Deg(15.0));
  const double s = std::sin(core::Deg(15.0));
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= 50; ++i) {
      for (int k = 0; k < 15; ++k) {
        const double d = 0.001 + 0.002 * k;
        roof.Add({0.002 * i, 0.03 + side * c * d, 0.08 - s * d}, {0.0, side * s, c});
      }
    }
  }
  const auto ridge = RidgeOf(roof);
  ASSERT_TRUE(ridge);
  EXPECT_NEAR(std::abs(ridge->axis.x()), 1.0, 1e-9);
  EXPECT_NEAR(ridge->point.y(), 0.03, 1e-9);
}

TEST(FindRidge, RefusesPlanesSpheresAndFlatArcs) {
  Analytic plane;
  plane.AddRectangle({0.0, 0.0, 0.05}, {0.05, 0.0, 0.0}, {0.0, 0.03, 0.0});
  EXPECT_FALSE(RidgeOf(plane));

  Analytic sphere;
  core::Rng rng(2);
  for (int i = 0; i < 3000; ++i) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    const Vector3d n = Vector3d(x, y, std::abs(rng.Normal())).normalized();
    sphere.Add(Vector3d(0.0, 0.0, 0.05) + 0.04 * n, n);
  }
  EXPECT_FALSE(RidgeOf(sphere));

  // Normals within 10 deg of the vertical: the middle 60 % of them spread over 12 deg.
  EXPECT_FALSE(RidgeOf(Lying({0.0, 0.0, 0.0}, 0.3, 0.2, 0.2, -0.17, 0.17)));
}

TEST(FindRidge, RefusesTheNearLipAndTheFarWallOfACup) {
  // Both face the sensor (and so do both ends of their normals' spread), whatever their side.
  Analytic cup;
  for (const double y : {-0.04, 0.04}) {
    for (int i = -20; i <= 20; ++i) {
      for (int k = 0; k <= 30; ++k) {
        const double t = -0.9 + 1.8 * k / 30;
        cup.Add({0.002 * i, y + 0.001 * (k % 3), 0.08}, {0.0, std::sin(t), std::cos(t)});
      }
    }
  }
  EXPECT_FALSE(RidgeOf(cup));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
