// The hierarchical method on clouds of shapes whose parts are known analytically.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "geometry/random_points.h"
#include "parts/cloud/cloud_samples.h"
#include "parts/hierarchy/hierarchy.h"
#include "parts/metrics/human_score.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;
using samples::BallPoint;
using samples::Noisy;

/// A cloud with the part of each point.
struct Labelled {
  Shape cloud;
  std::vector<std::int32_t> part;

  void Add(const Vector3d& p, std::int32_t label) {
    cloud.points.push_back(p);
    part.push_back(label);
  }
};

/// Two unit balls around x = -1.2 and 1.2 with a rod of radius 0.3 between them.
Labelled CloudHierarchyDumbbell(int count, double noise, std::uint64_t seed) {
  base::Rng rng(seed);
  Labelled result;
  while (result.cloud.points.size() < static_cast<std::size_t>(count)) {
    // Areas: two balls of 4 pi, and a rod of 0.6 pi per length with 0.49 outside of the balls.
    const double where = rng.Uniform(0.0, 8.0 + 0.6 * 0.49);
    if (where < 8.0) {
      const double side = where < 4.0 ? -1.0 : 1.0;
      const Vector3d p = BallPoint(rng) + Vector3d(1.2 * side, 0.0, 0.0);
      if (std::hypot(p.y(), p.z()) < 0.3 && side * p.x() < 1.2) continue;
      result.Add(Noisy(p, noise, rng), side < 0.0 ? 0 : 1);
    } else {
      const double angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
      const double x = rng.Uniform(-0.245, 0.245);
      result.Add(Noisy({x, 0.3 * std::cos(angle), 0.3 * std::sin(angle)}, noise, rng),
                 x < 0.0 ? 0 : 1);
    }
  }
  return result;
}

/// An open mug with wall thickness 0.2, radius 1 and height 2 about the z axis. On its +x side is a
/// handle: half a ring of radius 0.6 and tube radius 0.2.
Labelled Mug(int count, double noise, std::uint64_t seed) {
  constexpr double kPi = std::numbers::pi;
  base::Rng rng(seed);
  Labelled result;
  const auto on_wall = [&](double radius, double z) {
    const double angle = rng.Uniform(0.0, 2.0 * kPi);
    return Vector3d(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  const auto on_disc = [&](double inner, double outer, double z) {
    return on_wall(std::sqrt(rng.Uniform(inner * inner, outer * outer)), z);
  };
  // Outer wall, inner wall, bottom, floor, rim, handle.
  const double areas[] = {4.0 * kPi,  0.8 * 1.8 * 2.0 * kPi,      kPi, 0.64 * kPi,
                          0.36 * kPi, 0.6 * kPi * 0.2 * 2.0 * kPi};
  const double total = std::accumulate(std::begin(areas), std::end(areas), 0.0);
  while (result.cloud.points.size() < static_cast<std::size_t>(count)) {
    double where = rng.Uniform(0.0, total);
    int kind = 0;
    while (kind < 5 && where >= areas[kind]) where -= areas[kind++];
    Vector3d p;
    if (kind == 0) p = on_wall(1.0, rng.Uniform(-1.0, 1.0));
    if (kind == 1) p = on_wall(0.8, rng.Uniform(-0.8, 1.0));
    if (kind == 2) p = on_disc(0.0, 1.0, -1.0);
    if (kind == 3) p = on_disc(0.0, 0.8, -0.8);
    if (kind == 4) p = on_disc(0.8, 1.0, 1.0);
    if (kind == 5) {
      const double along = rng.Uniform(-0.5 * kPi, 0.5 * kPi);
      const double round = rng.Uniform(0.0, 2.0 * kPi);
      const double r = 0.6 + 0.2 * std::cos(round);
      p = {0.95 + r * std::cos(along), 0.2 * std::sin(round), r * std::sin(along)};
      if (std::hypot(p.x(), p.y()) < 1.0) continue;
    }
    // The handle covers the wall where it joins it.
    if (kind == 0 && p.x() > 0.0 && std::hypot(p.y(), std::abs(p.z()) - 0.6) < 0.2) continue;
    result.Add(Noisy(p, noise, rng), kind == 5 ? 1 : 0);
  }
  return result;
}

/// A unit ball with a fin of 1.5 by 0.9 on its +x side; both sides of the fin lie in one plane.
Labelled BallWithFin(int count, double noise, std::uint64_t seed) {
  base::Rng rng(seed);
  Labelled result;
  const double fin = 2.0 * 1.5 * 0.9;
  while (result.cloud.points.size() < static_cast<std::size_t>(count)) {
    if (rng.Uniform(0.0, 4.0 * std::numbers::pi + fin) < fin) {
      const double x = rng.Uniform(1.0, 2.5);
      result.Add(Noisy({x, rng.Uniform(-0.45, 0.45), 0.0}, noise, rng), 1);
    } else {
      result.Add(Noisy(BallPoint(rng), noise, rng), 0);
    }
  }
  return result;
}

class CloudGrades : public ::testing::TestWithParam<std::pair<int, double>> {};

TEST_P(CloudGrades, ADumbbellComesApartAtItsRod) {
  const auto [count, noise] = GetParam();
  const Labelled dumbbell = CloudHierarchyDumbbell(count, noise, 1);
  const Segmentation found = SegmentHierarchy(dumbbell.cloud, {});
  // The rod may join either ball or be a part: 2 % of the area, and twice that of the pairs.
  EXPECT_LE(RandError(found.label, dumbbell.part), 0.05);
  EXPECT_LE(found.parts, 3);
}

TEST_P(CloudGrades, AMugIsAContainerAndAHandle) {
  const auto [count, noise] = GetParam();
  const Labelled mug = Mug(count, noise, 2);
  const Segmentation found = SegmentHierarchy(mug.cloud, {});
  EXPECT_LE(found.parts, 3);  // a handle may be split at its bend
  // The handle has 8 % of the points. A tenth of it may be wrong at its ends, in pairs with all
  // others.
  EXPECT_LE(RandError(found.label, mug.part), 0.016);
}

// In units of a ball's radius; the shapes are 4.5 and 3.7 across: 0.2 and 0.5 % of that.
INSTANTIATE_TEST_SUITE_P(Grades, CloudGrades,
                         ::testing::Values(std::pair(6'000, 0.0), std::pair(10'000, 0.008),
                                           std::pair(30'000, 0.02)));

TEST(CloudHierarchy, WhatIsThinnerThanItsNoiseIsAPart) {
  // 0.5 % of 4.3 across. At the joint with the ball, a strip of a tenth of the fin may be wrong.
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Labelled finned = BallWithFin(10'000, 0.02, seed);
    const Segmentation found = SegmentHierarchy(finned.cloud, {});
    EXPECT_EQ(found.parts, 2) << seed;
    EXPECT_LE(RandError(found.label, finned.part), 0.035) << seed;
  }
}

class CloudNoises : public ::testing::TestWithParam<double> {};

TEST_P(CloudNoises, PartsAreTheSameHoweverTheCloudLiesAndIsWrittenDown) {
  const Labelled mug = Mug(8'000, GetParam(), 4);
  const Segmentation first = SegmentHierarchy(mug.cloud, {});
  ASSERT_EQ(first.parts, 2);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    base::Rng rng(seed);
    const Indices order = geometry::samples::Permutation(mug.part.size(), rng);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(rng.Uniform(0.0, 6.0), BallPoint(rng)).toRotationMatrix();
    const double scale = std::exp(rng.Uniform(-6.0, 6.0));
    Shape cloud;
    std::vector<std::int32_t> expected;
    for (const std::uint32_t i : order) {
      cloud.points.emplace_back(scale * (turn * mug.cloud.points[i] + Vector3d(3.0, -2.0, 1.0)));
      expected.push_back(first.label[i]);
    }
    EXPECT_EQ(SegmentHierarchy(cloud, {}).label, expected);
  }
}

// In units of a ball's radius: a sixth and half of the spacing; with half, the mesh is wrapped.
INSTANTIATE_TEST_SUITE_P(LittleAndMuch, CloudNoises, ::testing::Values(0.01, 0.03));

TEST(CloudHierarchy, StraysMakeNoPartsAndGoWithTheNearest) {
  Labelled mug = Mug(8'000, 0.01, 4);
  base::Rng rng(9);
  for (int k = 0; k < 10; ++k) {
    mug.Add(BallPoint(rng) * rng.Uniform(4.0, 6.0), 0);
    if (mug.cloud.points.back().x() > 0.0)
      mug.cloud.points.back().x() *= -1.0;  // far from the handle
  }
  const Segmentation found = SegmentHierarchy(mug.cloud, {});
  EXPECT_LE(found.parts, 3);
  EXPECT_LE(RandError(found.label, mug.part), 0.016);
}

// A small part of the surface may not be the nearest to any point. Then it is not a part.
TEST(CloudHierarchy, EveryPartHasPoints) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Shape cloud = CloudHierarchyDumbbell(100, 0.0, seed).cloud;
    const Segmentation found = SegmentHierarchy(cloud, {});
    std::vector<int> points(static_cast<std::size_t>(found.parts), 0);
    for (const std::int32_t label : found.label) ++points.at(static_cast<std::size_t>(label));
    EXPECT_EQ(std::ranges::count(points, 0), 0) << "seed " << seed;
    EXPECT_EQ(found.has_core, found.parts > 1);
  }
}

}  // namespace
}  // namespace rangegrasp::parts
