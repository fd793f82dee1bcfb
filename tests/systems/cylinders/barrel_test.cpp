#include "cylinders/barrel.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/rng.h"
#include "cylinders/fit.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;

Vector3d Noise(double deviation, base::Rng& rng) {
  return deviation * geometry::samples::RandomVector(rng);
}

/// Adds the visible part of a barrel from low to high along its axis, over `arc` about `facing`.
void AddBarrel(const Vector3d& center, const Vector3d& axis, const Vector3d& facing,
               double radius_m, double low_m, double high_m, double arc_rad, double noise_m,
               int count, base::Rng& rng, geometry::PointCloud& cloud) {
  const Vector3d u = (facing - facing.dot(axis) * axis).normalized();
  const Vector3d v = axis.cross(u);
  for (int i = 0; i < count; ++i) {
    const double angle = rng.Uniform(-0.5 * arc_rad, 0.5 * arc_rad);
    const double along = rng.Uniform(low_m, high_m);
    const Vector3d n = std::cos(angle) * u + std::sin(angle) * v;
    cloud.points.push_back(center + along * axis + (radius_m + noise_m * rng.Normal()) * n);
    cloud.normals.push_back((n + Noise(0.05, rng)).normalized());
  }
}

void AddDisc(const Vector3d& center, const Vector3d& normal, double radius_m, int count,
             base::Rng& rng, geometry::PointCloud& cloud) {
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  for (int i = 0; i < count; ++i) {
    const double r = radius_m * std::sqrt(rng.Uniform());
    const double angle = rng.Uniform(0.0, 2.0 * base::kPi);
    cloud.points.push_back(center + r * std::cos(angle) * u + r * std::sin(angle) * v +
                           0.0003 * rng.Normal() * normal);
    cloud.normals.push_back(normal);
  }
}

geometry::Indices All(const geometry::PointCloud& cloud) {
  geometry::Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

TEST(Barrel, PointsAreThoseNearTheSurfaceBetweenTheEnds) {
  base::Rng rng(1);
  geometry::Points points;
  for (int i = 0; i < 2000; ++i) points.push_back(Noise(0.03, rng));
  const Line axis{{0.01, 0, 0}, Vector3d(1, 1, 0).normalized()};
  geometry::Indices naive;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const double along = (points[i] - axis.point).dot(axis.direction);
    if (std::abs(axis.Distance(points[i]) - 0.03) <= 0.002 && along >= -0.02 && along <= 0.05) {
      naive.push_back(i);
    }
  }
  EXPECT_EQ(BarrelPoints(points, axis, 0.03, -0.02, 0.05, 0.002), naive);
  EXPECT_GT(naive.size(), 20u);
}

class SeededBarrel : public testing::TestWithParam<int> {};

TEST_P(SeededBarrel, IsRefinedFromAnAxisThatIsOff) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  const Vector3d axis = Noise(1.0, rng).normalized();
  const Vector3d facing = axis.unitOrthogonal();
  const Vector3d center(0.2, -0.1, 0.5);
  geometry::PointCloud cloud;
  AddBarrel(center, axis, facing, 0.02575, -0.08, 0.08, base::Deg(140), 0.0003, 1500, rng, cloud);
  // A wall that touches the barrel, with a fifth as many points.
  for (int i = 0; i < 300; ++i) {
    const double along = rng.Uniform(-0.08, 0.0);
    const Vector3d side = axis.cross(facing);
    cloud.points.push_back(center + along * axis + 0.02575 * side +
                           rng.Uniform(-0.02, 0.02) * facing);
    cloud.normals.push_back(facing);
  }
  Line start{center + 0.002 * facing, (axis + 0.02 * axis.cross(facing)).normalized()};
  const auto refined = RefineAxis(cloud, All(cloud), start, 0.02575, {});
  ASSERT_TRUE(refined);
  // 1500 points with 0.3 mm noise give hundredths of a mm and of a degree; ten times that.
  EXPECT_LT(refined->axis.Distance(center), 0.0002);
  EXPECT_LT(AngleBetween(refined->axis.direction, axis), base::Deg(0.2));
  EXPECT_NEAR(refined->radius_m, 0.02575, 0.0002);
  EXPECT_NEAR(refined->arc_rad, base::Deg(140), base::Deg(20));
  EXPECT_LT(refined->normal_angle_rad, base::Deg(6));
}
INSTANTIATE_TEST_SUITE_P(Seeds, SeededBarrel, testing::Range(1, 30));

TEST(Barrel, CornerOfABoxHasNormalsThatAreNotRadial) {
  base::Rng rng(2);
  geometry::PointCloud cloud;
  for (int i = 0; i < 3000; ++i) {
    const double across = rng.Uniform(-0.026, 0.026);
    const double up = rng.Uniform(0.0, 0.15);
    const bool side = i % 2 == 0;
    cloud.points.push_back(side ? Vector3d(0.026, across, up) : Vector3d(across, 0.026, up));
    cloud.normals.push_back(side ? Vector3d::UnitX() : Vector3d::UnitY());
  }
  const auto refined = RefineAxis(cloud, All(cloud), {{0, 0, 0.07}, Vector3d::UnitZ()}, 0.027, {});
  if (refined) {
    EXPECT_GT(refined->normal_angle_rad, base::Deg(9.5));
    EXPECT_LE(refined->arc_rad, base::Deg(70));
  }
}

TEST(Barrel, NoAxisOfTooFewPoints) {
  base::Rng rng(3);
  geometry::PointCloud cloud;
  AddBarrel({0, 0, 0}, Vector3d::UnitZ(), Vector3d::UnitX(), 0.02, -0.05, 0.05, 2.0, 0.0, 10, rng,
            cloud);
  EXPECT_FALSE(RefineAxis(cloud, All(cloud), {}, 0.02, {}));
}

TEST(Barrel, EndsAreAtTheFaceThatIsSeenAndWhereItsPointsEnd) {
  base::Rng rng(4);
  geometry::PointCloud cloud;
  const Vector3d axis = Vector3d::UnitZ();
  AddBarrel({0, 0, 0}, axis, Vector3d::UnitX(), 0.026, -0.06, 0.05, 2.4, 0.0003, 2000, rng, cloud);
  AddDisc({0, 0, 0.051}, axis, 0.025, 300, rng, cloud);
  const auto all = All(cloud);
  const auto refined = RefineAxis(cloud, all, {{0, 0, 0}, axis}, 0.026, {});
  ASSERT_TRUE(refined);
  const auto ends = FindEnds(cloud, all, *refined, 0.026, 0.2, {});
  ASSERT_TRUE(ends);
  const double up = refined->axis.direction.z();
  ASSERT_GT(up, 0.99);
  EXPECT_TRUE(ends->high_face);
  EXPECT_FALSE(ends->low_face);
  EXPECT_NEAR(ends->high_m + refined->axis.point.z(), 0.051, 0.0005);
  EXPECT_NEAR(ends->low_m + refined->axis.point.z(), -0.06, 0.001);
}

TEST(Barrel, WhatStandsInFrontOfItsMiddleDoesNotEndItAndWhatContinuesItDoesNotLengthenIt) {
  base::Rng rng(5);
  const Vector3d axis = Vector3d::UnitZ();
  geometry::PointCloud cloud;
  AddBarrel({0, 0, 0}, axis, Vector3d::UnitX(), 0.026, -0.06, -0.02, 2.4, 0.0003, 900, rng, cloud);
  AddBarrel({0, 0, 0}, axis, Vector3d::UnitX(), 0.026, 0.02, 0.05, 2.4, 0.0003, 700, rng, cloud);
  AddBarrel({0, 0, 0}, axis, Vector3d::UnitX(), 0.026, 0.12, 0.14, 2.4, 0.0003, 500, rng, cloud);
  const auto all = All(cloud);
  const auto refined = RefineAxis(cloud, all, {{0, 0, 0}, axis}, 0.026, {});
  ASSERT_TRUE(refined);
  const auto ends = FindEnds(cloud, all, *refined, 0.026, 0.125, {});
  ASSERT_TRUE(ends);
  EXPECT_NEAR(ends->Length(), 0.11, 0.002);
}

TEST(BarrelSearch, FindsAStandingAndALyingBarrelAmongWalls) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    base::Rng rng(seed);
    const Vector3d up = Noise(1.0, rng).normalized();
    const Vector3d lying = up.unitOrthogonal();
    const Vector3d to_sensor = (up + lying.cross(up)).normalized();
    const Vector3d a = Vector3d(0.3, 0.1, 0.5);
    const Vector3d b = a + 0.15 * lying;
    geometry::PointCloud cloud;
    AddBarrel(a, up, to_sensor, 0.026, -0.07, 0.07, 2.2, 0.0003, 900, rng, cloud);
    AddBarrel(b, lying, to_sensor, 0.026, -0.05, 0.05, 2.2, 0.0003, 700, rng, cloud);
    for (int i = 0; i < 1500; ++i) {  // a wall
      cloud.points.push_back(a - 0.1 * lying + rng.Uniform(-0.05, 0.05) * up.cross(lying) +
                             rng.Uniform(-0.05, 0.05) * up);
      cloud.normals.push_back(lying);
    }
    const auto lines = FindBarrels(cloud, up, 0.026, 0.14, {}, rng);
    const auto near = [&](const Vector3d& center, const Vector3d& axis) {
      return std::ranges::any_of(lines, [&](const Line& line) {
        return line.Distance(center) < 0.003 && AngleBetween(line.direction, axis) < base::Deg(4) &&
               (line.point - center).norm() < 0.1;
      });
    };
    EXPECT_TRUE(near(a, up)) << seed;
    EXPECT_TRUE(near(b, lying)) << seed;
  }
}

TEST(BarrelSearch, FindsALeaningBarrelAmongWalls) {
  const Vector3d up = Vector3d::UnitZ();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    base::Rng rng(seed);
    const double lean = rng.Uniform(0.3, 1.2);
    const Vector3d axis(std::sin(lean), 0.0, std::cos(lean));
    const Vector3d a(0.3, 0.1, 0.5);
    geometry::PointCloud cloud;
    AddBarrel(a, axis, Vector3d(-0.5, -0.5, 0.7), 0.026, -0.06, 0.06, 2.2, 0.0003, 500, rng, cloud);
    for (int i = 0; i < 1500; ++i) {  // a wall and a top
      const double x = rng.Uniform(-0.05, 0.05);
      const double y = rng.Uniform(-0.05, 0.05);
      const bool wall = i % 2 == 0;
      cloud.points.push_back(a + (wall ? Vector3d(x, 0.1, y) : Vector3d(x, 0.15 + y, 0.05)));
      cloud.normals.push_back(wall ? Vector3d(0, -1, 0) : up);
    }
    const auto lines = FindBarrels(cloud, up, 0.026, 0.12, {}, rng);
    EXPECT_TRUE(std::ranges::any_of(lines, [&](const Line& line) {
      return line.Distance(a) < 0.003 && AngleBetween(line.direction, axis) < base::Deg(4);
    })) << seed;
  }
}

}  // namespace
}  // namespace rangegrasp::cylinders
