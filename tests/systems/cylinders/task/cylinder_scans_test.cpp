#include "cylinders/task/cylinder_scans.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace rangegrasp::cylinders {
namespace {

// Distance of p from the surface of the cylinder.
double OffSurface(const CylinderShape& shape, const Eigen::Vector3d& p) {
  const double across = p.tail<2>().norm() - shape.radius_m;
  const double along = std::abs(p.x()) - 0.5 * shape.height_m;
  return std::abs(std::max(across, along));
}

TEST(SyntheticScan, HasSoManyPointsOnTheSurfaceThatTheEyeSees) {
  const CylinderShape shape{0.02575, 0.173};
  base::Rng rng(3);
  const auto points = SyntheticScan(shape, 5000, 0.0, rng);
  ASSERT_EQ(points.size(), 5000u);
  int end = 0;
  for (const auto& p : points) {
    EXPECT_LT(OffSurface(shape, p), 1e-9);
    const bool on_end = p.x() > 0.5 * shape.height_m - 1e-9;
    end += on_end ? 1 : 0;
    // The wall's outward normal faces the eye.
    const Eigen::Vector3d normal(0.0, p.y(), p.z());
    EXPECT_TRUE(on_end || normal.dot(SensorPosition() - p) > -1e-9);
  }
  // From far away, the end's ellipse has an area of pi r^2 sin(37 deg) and the wall one of 2 r h
  // cos(37 deg); from 0.9 m the nearer end gets a few more points.
  EXPECT_NEAR(end / 5000.0, 0.15, 0.03);
}

TEST(SyntheticScan, NoiseMovesPointsAlongTheirRays) {
  const CylinderShape shape;
  base::Rng rng(3), same(3);
  const auto exact = SyntheticScan(shape, 1000, 0.0, rng);
  const auto noisy = SyntheticScan(shape, 1000, 0.0005, same);
  double squares = 0.0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const Eigen::Vector3d moved = noisy[i] - exact[i];
    EXPECT_LT(moved.cross(exact[i] - SensorPosition()).norm(), 1e-12);
    squares += moved.squaredNorm();
  }
  // 5 standard errors of a standard deviation from 1,000 points are 11 %.
  EXPECT_NEAR(std::sqrt(squares / 1000.0), 0.0005, 0.00006);
}

TEST(ScannedCylinder, HasSoManyPointsNearTheSurfaceAndNoneOfTheTable) {
  const CylinderShape shape;
  base::Rng rng(3);
  const auto points = ScanCylinder(shape, 1000, {}, rng);
  ASSERT_EQ(points.size(), 1000u);
  int far = 0;
  for (const auto& p : points) {
    EXPECT_GT(p.x(), -0.5 * shape.height_m + 0.002);
    far += OffSurface(shape, p) > 0.003 ? 1 : 0;  // mixed points at the outline
  }
  EXPECT_LT(far, 50);
}

TEST(KeepEvenly, KeepsTheOrderAndTheEndsShare) {
  geometry::Points points;
  for (int i = 0; i < 100; ++i) points.emplace_back(i, 0.0, 0.0);
  KeepEvenly(25, points);
  ASSERT_EQ(points.size(), 25u);
  for (std::size_t i = 0; i < 25; ++i) {
    EXPECT_EQ(points[i].x(), static_cast<double>(4 * i + 3));
  }
}

}  // namespace
}  // namespace rangegrasp::cylinders
