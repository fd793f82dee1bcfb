#include "cylinders/curvature.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/rng.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;
using geometry::samples::RandomVector;

/// Two faces of a box that meet along y at the origin: points 2 mm apart, exact normals.
geometry::PointCloud Edge() {
  geometry::PointCloud cloud;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 20; ++k) {
      cloud.points.emplace_back(-0.001 - 0.002 * i, 0.002 * k, 0.0);
      cloud.normals.push_back(Vector3d::UnitZ());
      cloud.points.emplace_back(0.0, 0.002 * k, -0.001 - 0.002 * i);
      cloud.normals.push_back(Vector3d::UnitX());
    }
  }
  return cloud;
}

TEST(Curvature, MeanCosineIsTheSumOfTheEquationByItsCount) {
  base::Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    const Vector3d n = RandomVector(rng);
    geometry::Points others;
    for (int k = 0; k < 9; ++k) others.push_back(RandomVector(rng));
    double sum = 0.0;
    for (const auto& t : others) {
      sum += (n[0] * t[0] + n[1] * t[1] + n[2] * t[2]) /
             (std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) *
              std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]));
    }
    EXPECT_NEAR(MeanCosine(n, others), sum / 9.0, 1e-12);
    EXPECT_LE(std::abs(MeanCosine(n, others)), 1.0);
  }
  EXPECT_EQ(MeanCosine(Vector3d::UnitX(), {}), 1.0);
}

TEST(Curvature, EdgeCosineIsThatOfTheEquation) {
  base::Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d before = RandomVector(rng);
    const Vector3d p = RandomVector(rng);
    const Vector3d after = RandomVector(rng);
    double dot = 0.0;
    double one = 0.0;
    double other = 0.0;
    for (int k = 0; k < 3; ++k) {
      dot += (p[k] - before[k]) * (p[k] - after[k]);
      one += (p[k] - before[k]) * (p[k] - before[k]);
      other += (p[k] - after[k]) * (p[k] - after[k]);
    }
    EXPECT_NEAR(EdgeCosine(before, p, after), dot / (std::sqrt(one) * std::sqrt(other)), 1e-12);
  }
  EXPECT_NEAR(EdgeCosine({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), -1.0, 1e-12);
  EXPECT_NEAR(EdgeCosine({0, 0, 0}, {1, 0, 0}, {1, 1, 0}), 0.0, 1e-12);
  EXPECT_EQ(EdgeCosine({1, 0, 0}, {1, 0, 0}, {2, 0, 0}), -1.0);
}

TEST(Curvature, CurvedPointsAreThoseOfANaiveLoop) {
  base::Rng rng(3);
  geometry::PointCloud cloud = Edge();
  for (auto& n : cloud.normals) n = (n + 0.1 * RandomVector(rng)).normalized();
  const CurvatureOptions options;
  const auto curved = CurvedPoints(cloud, geometry::KdTree(cloud.points), options);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    geometry::Points others;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      if (k != i && (cloud.points[k] - cloud.points[i]).norm() < options.radius_m) {
        others.push_back(cloud.normals[k]);
      }
    }
    const double angle = std::acos(MeanCosine(cloud.normals[i], others));
    EXPECT_EQ(curved[i], angle > base::Deg(20.0)) << i;
  }
}

TEST(Curvature, NeighborsThatAreKnownChangeNothing) {
  base::Rng rng(5);
  geometry::PointCloud cloud = Edge();
  for (auto& p : cloud.points) p += 0.0003 * RandomVector(rng);
  const geometry::KdTree tree(cloud.points);
  const CurvatureOptions options;
  const Vector3d eye(1.0, 0.0, 1.0);
  for (const double radius_m : {double{options.radius_m}, 0.5 * options.radius_m}) {
    geometry::NeighborLists known;
    cloud.normals =
        geometry::EstimateNormals(cloud.points, tree, radius_m, {&eye, 1},
                                  geometry::Indices(cloud.size(), 0), 2.0 * radius_m, &known);
    ASSERT_TRUE(known.Has(cloud.size() - 1));
    EXPECT_EQ(CurvedPoints(cloud, tree, options, known), CurvedPoints(cloud, tree, options));
    // Some points' lists may not have been kept.
    known.ends.resize(cloud.size() / 2);
    EXPECT_EQ(CurvedPoints(cloud, tree, options, known), CurvedPoints(cloud, tree, options));
  }
}

TEST(Curvature, OnlyWhatIsNearAnEdgeIsCurved) {
  const geometry::PointCloud cloud = Edge();
  const auto curved = CurvedPoints(cloud, geometry::KdTree(cloud.points), {});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double from_edge = Vector3d(cloud.points[i].x(), 0.0, cloud.points[i].z()).norm();
    if (from_edge < 0.002) {
      EXPECT_TRUE(curved[i]) << i;
    }
    if (from_edge > 0.005) {
      EXPECT_FALSE(curved[i]) << i;
    }
  }
}

TEST(Curvature, LineEdgesAreThoseOfTheEquationOverAdjacentSamples) {
  base::Rng rng(4);
  geometry::Points points;
  std::vector<ScanPlace> places;
  for (std::uint32_t line = 0; line < 5; ++line) {
    for (std::uint32_t sample = 0; sample < 40; ++sample) {
      points.push_back(Vector3d(0.01 * sample, 0.02 * line, 0.0) + 0.01 * RandomVector(rng));
      places.push_back({line, sample});
    }
  }
  CurvatureOptions options;
  options.line_step_m = 0.0;
  const auto edges = LineEdges(points, places, options);
  int found = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool edge = false;
    if (i % 40 != 0 && i % 40 != 39) {
      edge = std::acos(EdgeCosine(points[i - 1], points[i], points[i + 1])) < base::Deg(110.0);
    }
    EXPECT_EQ(edges[i], edge) << i;
    found += edge;
  }
  EXPECT_GT(found, 10);
  EXPECT_THROW(LineEdges(points, {}, options), std::invalid_argument);
}

TEST(Curvature, NoiseOfDenseSamplesIsNoEdge) {
  // A straight line of samples 0.2 mm apart with 0.1 mm noise, and one that bends by a right angle.
  base::Rng rng(5);
  geometry::Points points;
  std::vector<ScanPlace> places;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double along = 0.0002 * i - 0.04;
    points.push_back(Vector3d(std::min(along, 0.0), std::max(along, 0.0), 0.0) +
                     0.0001 * RandomVector(rng));
    places.push_back({0, i});
  }
  CurvatureOptions options;
  options.line_step_m = 0.002;
  const auto edges = LineEdges(points, places, options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double from_edge = std::abs(0.0002 * static_cast<double>(i) - 0.04);
    if (from_edge < 0.0003) {
      EXPECT_TRUE(edges[i]) << i;
    }
    if (from_edge > 0.0025) {
      EXPECT_FALSE(edges[i]) << i;
    }
  }
  options.line_step_m = 0.0;
  const auto adjacent = LineEdges(points, places, options);
  EXPECT_GT(std::ranges::count(adjacent, true), 20);
}

TEST(Curvature, SensorGateIsThePublishedOne) {
  EXPECT_TRUE(PassesSensorGate({0.8, 0.5, 0.3}));
  EXPECT_FALSE(PassesSensorGate({0.5, 0.8, 0.3}));
  EXPECT_FALSE(PassesSensorGate({0.5, 0.3, 0.8}));
  EXPECT_TRUE(PassesSensorGate({0.1, -0.99, 0.0}));
}

}  // namespace
}  // namespace rangegrasp::cylinders
