#include "cylinders/axis_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;

struct Barrel {
  geometry::Points points, normals;
};

/// The half of a barrel that faces +x, its axis along `axis` through `center`.
Barrel HalfBarrel(const Vector3d& center, const Vector3d& axis, double radius_m, double height_m,
                  double normal_noise, base::Rng& rng) {
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  Barrel barrel;
  for (int i = 0; i < 2000; ++i) {
    const double angle = rng.Uniform(-base::kPi / 2, base::kPi / 2);
    const double along = rng.Uniform(-0.5, 0.5) * height_m;
    const Vector3d n = std::cos(angle) * u + std::sin(angle) * v;
    const double a = rng.Normal();
    const double b = rng.Normal();
    const double c = rng.Normal();
    barrel.points.push_back(center + along * axis + radius_m * n);
    barrel.normals.push_back((n + normal_noise * Vector3d(a, b, c)).normalized());
  }
  return barrel;
}

double AngleBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
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
  EXPECT_THROW(AxisPoints(p, {}, 0.5), std::invalid_argument);
}

TEST(CylinderAxis, DirectionIsTheEigenvectorOfTheLargestEigenvalue) {
  base::Rng rng(2);
  geometry::Points points;
  for (int i = 0; i < 50; ++i) {
    const double x = 3.0 * rng.Normal();
    const double y = rng.Normal();
    const double z = 0.5 * rng.Normal();
    points.emplace_back(x, y, z);
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
  // C v = lambda v, with the largest lambda: no direction has a larger variance.
  const double lambda = line->direction.dot(c * line->direction);
  EXPECT_LT((c * line->direction - lambda * line->direction).norm(), 1e-9);
  EXPECT_GE(lambda, c.trace() / 3.0);
  EXPECT_LT((line->point - mean).norm(), 1e-12);
}

TEST(CylinderAxis, TrimmedLineForgetsNormalsOfNeighbors) {
  base::Rng rng(3);
  const Vector3d axis = Vector3d::UnitZ();
  auto barrel = HalfBarrel(Vector3d::Zero(), axis, 0.026, 0.17, 0.02, rng);
  for (int i = 0; i < 300; ++i) {  // a box's wall at one side, at the lower half
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

}  // namespace
}  // namespace rangegrasp::cylinders
