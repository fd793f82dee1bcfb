#include "cylinders/cylinder.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/fit.h"
#include "cylinders/task/tabletop_scan.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;

struct SeenBarrel {
  geometry::Points points, normals;
};

/// The half of a barrel that faces +x; its axis goes along `axis` through `center`.
SeenBarrel HalfBarrel(const Vector3d& center, const Vector3d& axis, double radius_m,
                      double height_m, double normal_noise, base::Rng& rng) {
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  SeenBarrel barrel;
  for (int i = 0; i < 2000; ++i) {
    const double angle = rng.Uniform(-base::kPi / 2, base::kPi / 2);
    const double along = rng.Uniform(-0.5, 0.5) * height_m;
    const Vector3d n = std::cos(angle) * u + std::sin(angle) * v;
    barrel.points.push_back(center + along * axis + radius_m * n);
    barrel.normals.push_back(
        (n + normal_noise * geometry::samples::RandomVector(rng)).normalized());
  }
  return barrel;
}

TEST(CylinderAxis, PointsOfABarrelWithExactNormalsGiveItsAxis) {
  base::Rng rng(1);
  const Vector3d axis = Vector3d(0.3, -0.2, 0.9).normalized();
  const auto barrel = HalfBarrel({0.1, 0.2, 0.3}, axis, 0.026, 0.17, 0.0, rng);
  const auto line = FitLine(AxisPoints(barrel.points, barrel.normals, 0.026));
  ASSERT_TRUE(line);
  EXPECT_LT(AngleBetween(line->direction, axis), 1e-9);
  EXPECT_LT(line->Distance({0.1, 0.2, 0.3}), 1e-9);
}

TEST(CylinderAxis, AxisPointsGoInwardAlongTheNormal) {
  const geometry::Points p = {{1, 2, 3}};
  const geometry::Points n = {{0, 1, 0}};
  EXPECT_EQ(AxisPoints(p, n, 0.5).front(), Vector3d(1, 1.5, 3));
}

TEST(CylinderAxis, NormalsOfABarrelAreRadialThoseOfAnEndAreNot) {
  const Vector3d axis = Vector3d::UnitZ();
  EXPECT_TRUE(IsRadial(Vector3d::UnitX(), axis));
  EXPECT_TRUE(IsRadial(Vector3d(1.0, 0.0, -0.9).normalized(), axis));
  EXPECT_FALSE(IsRadial(Vector3d(1.0, 0.0, -1.1).normalized(), axis));
  EXPECT_FALSE(IsRadial(-axis, axis));
}

TEST(CylinderAxis, DirectionIsTheEigenvectorOfTheLargestEigenvalue) {
  base::Rng rng(2);
  geometry::Points points;
  for (int i = 0; i < 50; ++i) {
    points.push_back(geometry::samples::RandomVector(rng).cwiseProduct(Vector3d(3.0, 1.0, 0.5)));
  }
  Vector3d mean = Vector3d::Zero();
  for (const auto& p : points) mean += p / 50.0;
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  for (const auto& p : points) {
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 3; ++col) {
        c(row, col) += (p[row] - mean[row]) * (p[col] - mean[col]) / 49.0;
      }
    }
  }
  const auto line = FitLine(points);
  ASSERT_TRUE(line);
  // C v = lambda v with the largest lambda: no direction has a larger variance.
  const double lambda = line->direction.dot(c * line->direction);
  EXPECT_LT((c * line->direction - lambda * line->direction).norm(), 1e-9);
  EXPECT_GE(lambda, c.trace() / 3.0);
  EXPECT_LT((line->point - mean).norm(), 1e-12);
}

TEST(CylinderAxis, TrimmedLineForgetsNormalsOfNeighbors) {
  base::Rng rng(3);
  const Vector3d axis = Vector3d::UnitZ();
  auto barrel = HalfBarrel(Vector3d::Zero(), axis, 0.026, 0.17, 0.02, rng);
  for (int i = 0; i < 300; ++i) {  // a box's wall next to the lower half, on one side
    const double y = rng.Uniform(0.0, 0.05);
    barrel.points.emplace_back(0.02, y, rng.Uniform(-0.08, 0.0));
    barrel.normals.emplace_back(0.0, 0.0, 1.0);
  }
  const auto points = AxisPoints(barrel.points, barrel.normals, 0.026);
  const auto line = FitTrimmedLine(points);
  ASSERT_TRUE(line);
  EXPECT_LT(AngleBetween(line->direction, axis), base::Deg(1.0));
  EXPECT_GT(AngleBetween(FitLine(points)->direction, axis), base::Deg(2.0));
}

TEST(CylinderAxis, NoLineOfOnePlace) {
  EXPECT_FALSE(FitLine({}));
  EXPECT_FALSE(FitLine(geometry::Points(5, Vector3d(1, 2, 3))));
  EXPECT_FALSE(FitTrimmedLine({}));
}

TEST(CylinderAxis, CenterLiesOnTheAxisAtTheRimsMeanHeight) {
  const Line axis{{0.1, 0.2, 0.0}, Vector3d(0.1, 0.0, 1.0).normalized()};
  const geometry::Points rim = {{5, 5, 0.16}, {-5, 3, 0.18}};
  const auto center = CenterOnAxis(axis, rim, Vector3d::UnitZ());
  ASSERT_TRUE(center);
  EXPECT_LT((*center - Vector3d(0.117, 0.2, 0.17)).norm(), 1e-12);
  EXPECT_FALSE(CenterOnAxis(axis, {}, Vector3d::UnitZ()));
  EXPECT_FALSE(CenterOnAxis({Vector3d::Zero(), Vector3d::UnitX()}, rim, Vector3d::UnitZ()));
}

TEST(CylinderAxis, CenterOfGravityIsHalfTheHeightBelowTheTop) {
  const Vector3d v = Vector3d(0.2, 0.1, 0.9).normalized();
  const Vector3d c_m(0.1, 0.2, 0.3);
  const Vector3d c_g = CenterOfGravity(c_m, v, 0.134);
  for (int k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(c_g[k], c_m[k] - 0.134 / 2.0 * v[k]);
  const Cylinder cylinder{c_g, v, 0.02, 0.134};
  EXPECT_LT((cylinder.Top() - c_m).norm(), 1e-12);
}

using geometry::samples::RandomVector;

bool IsReallyInside(const Cylinder& c, const Vector3d& p) {
  const double along = (p - c.center).dot(c.axis);
  return std::abs(along) < 0.5 * c.height_m && (p - c.center - along * c.axis).norm() < c.radius_m;
}

TEST(Visibility, EntryIsWhereStepsAlongTheRayFirstAreInside) {
  base::Rng rng(1);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Cylinder c{0.1 * RandomVector(rng), RandomVector(rng).normalized(), 0.2, 0.5};
    const Vector3d origin = 2.0 * RandomVector(rng).normalized();
    const Vector3d target = origin + 2.0 * (0.2 * RandomVector(rng) - origin);
    std::optional<double> stepped;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps && !stepped; ++k) {
      const double share = 1.2 * k / kSteps;
      if (IsReallyInside(c, origin + share * (target - origin))) stepped = share;
    }
    const auto entry = EntryOf(origin, target - origin, c);
    if (stepped) {
      ASSERT_TRUE(entry) << i;
      EXPECT_NEAR(entry->share, *stepped, 1.2 / kSteps + 1e-9) << i;
      const Vector3d at = origin + entry->share * (target - origin);
      const double along = std::abs((at - c.center).dot(c.axis));
      EXPECT_EQ(entry->by_end, along > 0.5 * c.height_m - 1e-9) << i;
      ++hits;
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Visibility, RayAlongTheAxisEntersByTheEnd) {
  const Cylinder c{{0, 0, 0}, Vector3d::UnitZ(), 0.03, 0.1};
  const auto entry = EntryOf({0, 0, 1}, {0, 0, -1}, c);
  ASSERT_TRUE(entry);
  EXPECT_NEAR(entry->share, 0.95, 1e-12);
  EXPECT_TRUE(entry->by_end);
  EXPECT_FALSE(EntryOf({0.1, 0, 1}, {0, 0, -1}, c));
  EXPECT_FALSE(EntryOf({1, 0, 0.2}, {-1, 0, 0}, c));
}

class SceneWithOneCylinder : public testing::Test {
 protected:
  ViewCounts Compare(const Cylinder& cylinder) {
    const geometry::Indices place_of(image_.points_C.size(), 0);
    return CompareWithView({image_.points_C, image_.origins_C, place_of}, cylinder, 0.003);
  }

  base::Rng rng_{3};
  Cylinder there_ = samples::Standing(0.0, 0.0, 0.0257, 0.15);
  geometry::RangeImage image_ = samples::Scan({{there_}, {}}, {}, rng_).views.front().image;
};

TEST_F(SceneWithOneCylinder, AgreesWithItselfAndNotWithOthers) {
  EXPECT_GT(Compare(there_).Agreement(), 0.97);
  EXPECT_EQ(Compare(there_).before, 0u);
  EXPECT_LT(Compare(samples::Standing(0.0, 0.1, 0.0257, 0.15)).Agreement(), 0.3);
  EXPECT_LT(Compare(samples::Standing(0.0, 0.0, 0.0257, 0.22)).Agreement(), 0.85);
  // A cylinder behind it would be partly hidden.
  EXPECT_GT(Compare(samples::Standing(-0.06, 0.0, 0.0257, 0.15)).before, 200u);
}

TEST_F(SceneWithOneCylinder, PointsOnItAreThoseNearItsSurface) {
  const auto on = PointsOn(image_.points_C, there_, 0.002);
  std::size_t high = 0, beside = 0;
  for (std::uint32_t i = 0; i < image_.points_C.size(); ++i) {
    const Vector3d& p = image_.points_C[i];
    const bool is_on = std::ranges::binary_search(on, i);
    if (p.z() >= 0.01) {
      EXPECT_TRUE(is_on) << p.transpose();
      ++high;
    } else if (p.head<2>().norm() > there_.radius_m + 0.005) {
      EXPECT_FALSE(is_on) << p.transpose();
      ++beside;
    }
  }
  EXPECT_GT(high, 500u);
  EXPECT_GT(beside, 500u);
}

TEST(Visibility, WhatIsSeenInsideAnOpenCylinderSaysNothing) {
  // A point inside, once seen through the top and once through the barrel.
  const Cylinder c{{0, 0, 0.05}, Vector3d::UnitZ(), 0.03, 0.1};
  const geometry::Points place = {{0, 0, 1}, {1, 0, 0.05}};
  const geometry::Points points = {{0, 0, 0.05}, {0, 0, 0.05}};
  const geometry::Indices place_of{0, 1};
  const auto counts = CompareWithView({points, place, place_of}, c, 0.002);
  EXPECT_EQ(counts.through, 1u);
  EXPECT_EQ(counts.on, 0u);
}

}  // namespace
}  // namespace rangegrasp::cylinders
