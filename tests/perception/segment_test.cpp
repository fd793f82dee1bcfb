#include "perception/segment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "geometry/normals.h"
#include "geometry/random_points.h"
#include "geometry/synthetic.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::PointCloud;
using geometry::Points;

const Eigen::Vector3d kSegmentSensor(0.8, 0.0, 0.62);

/// The objects of a scan with normals, without the table, and the label of each point.
struct SegmentObjects {
  PointCloud cloud;
  std::vector<int> label;
};

SegmentObjects ScanObjects(const std::vector<synthetic::Solid>& solids, std::uint64_t seed) {
  synthetic::ScanOptions options;
  options.seed = seed;
  options.sigma_m = 0.0002;
  const auto scan = synthetic::MakeScan(solids, options);
  SegmentObjects objects;
  for (std::size_t i = 0; i < scan.label.size(); ++i) {
    if (scan.label[i] < 0 || scan.points_W[i].z() < 0.004) continue;
    objects.cloud.points.push_back(scan.points_W[i]);
    objects.label.push_back(scan.label[i]);
  }
  objects.cloud.normals = geometry::EstimateNormals(
      objects.cloud.points, KdTree(objects.cloud.points), 0.005, kSegmentSensor);
  return objects;
}

std::vector<synthetic::Solid> TwoBoxes(double gap_m) {
  return {synthetic::Box{{0.0, -0.02 - gap_m / 2.0, 0.04}, {0.04, 0.04, 0.08}, 0.0},
          synthetic::Box{{0.0, 0.02 + gap_m / 2.0, 0.04}, {0.04, 0.04, 0.08}, 0.0}};
}

class BothMethods : public ::testing::TestWithParam<SegmentMethod> {
 protected:
  SegmentOptions Options() const {
    SegmentOptions options;
    options.method = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, BothMethods,
                         ::testing::Values(SegmentMethod::kMesh, SegmentMethod::kRegionGrowing));

TEST_P(BothMethods, BoxesTwentyMillimetresApartAreTwoSegments) {
  const SegmentObjects objects = ScanObjects(TwoBoxes(0.020), 1);
  const auto segments = Segment(objects.cloud, Options());
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].size() + segments[1].size(), objects.cloud.size());
  for (const Indices& segment : segments) {
    for (const std::uint32_t i : segment) {
      EXPECT_EQ(objects.label[i], objects.label[segment.front()]);
    }
  }
}

TEST_P(BothMethods, TouchingBoxesAreOneSegment) {
  const SegmentObjects objects = ScanObjects(TwoBoxes(0.0005), 2);
  EXPECT_EQ(Segment(objects.cloud, Options()).size(), 1u);
}

TEST_P(BothMethods, SegmentsDoNotDependOnTheOrderOfThePoints) {
  const SegmentObjects objects = ScanObjects(synthetic::MixedObjects(), 3);
  const auto segments = Segment(objects.cloud, Options());
  EXPECT_EQ(segments.size(), 5u);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    base::Rng rng(seed);
    const Indices order = geometry::samples::Permutation(objects.cloud.size(), rng);
    PointCloud shuffled;
    shuffled.points = geometry::Select(objects.cloud.points, order);
    shuffled.normals = geometry::Select(objects.cloud.normals, order);
    auto others = Segment(shuffled, Options());
    ASSERT_EQ(others.size(), segments.size());
    for (std::size_t k = 0; k < others.size(); ++k) {
      for (std::uint32_t& i : others[k]) i = order[i];
      std::sort(others[k].begin(), others[k].end());
      EXPECT_EQ(others[k], segments[k]);
    }
  }
}

TEST_P(BothMethods, SmallSegmentsAreDroppedAndTheRestGoesLargestFirst) {
  const SegmentObjects objects = ScanObjects(synthetic::MixedObjects(), 4);
  SegmentOptions options = Options();
  const auto all = Segment(objects.cloud, options);
  for (std::size_t k = 1; k < all.size(); ++k) EXPECT_LE(all[k].size(), all[k - 1].size());
  options.min_points = static_cast<int>(all[1].size());
  EXPECT_EQ(Segment(objects.cloud, options).size(), 2u);
}

TEST_P(BothMethods, TinyCloudsHaveNoSegment) {
  PointCloud cloud;
  EXPECT_TRUE(Segment(cloud, Options()).empty());
  cloud.points = {{0.0, 0.0, 0.0}};
  cloud.normals = {{0.0, 0.0, 1.0}};
  EXPECT_TRUE(Segment(cloud, Options()).empty());
}

TEST(NormalWeight, FollowsItsEquations) {
  base::Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = geometry::samples::RandomPoint(1.0, rng);
    const Eigen::Vector3d b = geometry::samples::RandomPoint(1.0, rng);
    const double cosine = (a.x() * b.x() + a.y() * b.y() + a.z() * b.z()) /
                          (std::sqrt(a.dot(a)) * std::sqrt(b.dot(b)));  // eq. 5.3
    EXPECT_NEAR(NormalWeight(a, b), 1.0 - std::abs(cosine), 1e-14);     // eq. 5.4
    EXPECT_NEAR(NormalWeight(a, -3.0 * a), 0.0, 1e-14);
  }
  EXPECT_EQ(NormalWeight({1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}), 1.0);
}

/// Algorithm 2 by flood filling, all pairs.
std::vector<Indices> FloodFill(const PointCloud& cloud, double d_a, double neighborhood) {
  std::vector<bool> done(cloud.size(), false);
  std::vector<Indices> regions;
  for (std::uint32_t start = 0; start < cloud.size(); ++start) {
    if (done[start]) continue;
    Indices region = {start};
    done[start] = true;
    for (std::size_t k = 0; k < region.size(); ++k) {
      const std::uint32_t i = region[k];
      for (std::uint32_t m = 0; m < cloud.size(); ++m) {
        const double d = (cloud.points[i] - cloud.points[m]).norm();  // eq. 5.2
        if (done[m] || d >= neighborhood * d_a) continue;
        if (d * NormalWeight(cloud.normals[i], cloud.normals[m]) >= d_a) continue;
        done[m] = true;
        region.push_back(m);
      }
    }
    std::sort(region.begin(), region.end());
    regions.push_back(region);
  }
  std::stable_sort(regions.begin(), regions.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return regions;
}

TEST(RegionGrowing, IsTheFloodFillOfAlgorithm2) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    base::Rng rng(seed);
    PointCloud cloud;
    cloud.points = geometry::samples::RandomPoints(300, 0.02, rng);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.normals.push_back(geometry::samples::RandomDirection(rng));
    }
    const double d_a =
        geometry::NearestNeighborDistances(cloud.points, KdTree(cloud.points)).mean_m;
    SegmentOptions options;
    options.min_points = 1;
    for (const double neighborhood : {1.5, 3.0, 6.0}) {
      options.neighborhood = neighborhood;
      const auto regions = SegmentByRegionGrowing(cloud.points, cloud.normals, options);
      EXPECT_EQ(regions, FloodFill(cloud, d_a, neighborhood));
      options.method = SegmentMethod::kRegionGrowing;
      EXPECT_EQ(Segment(cloud, options), regions);
    }
  }
}

TEST(RegionGrowing, NeedsOneNormalAPoint) {
  EXPECT_THROW(SegmentByRegionGrowing(Points(3, {0.0, 0.0, 0.0}), Points{}, {}),
               std::invalid_argument);
}

TEST(MeshAlpha, IsTheLargestNeighbourDistanceWithinBounds) {
  SegmentOptions options;
  EXPECT_EQ(MeshAlpha(0.005, options), 0.005);
  EXPECT_EQ(MeshAlpha(0.001, options), options.min_alpha_m);
  EXPECT_EQ(MeshAlpha(0.200, options), options.max_alpha_m);
  options.alpha_m = 0.02;
  EXPECT_EQ(MeshAlpha(0.005, options), 0.02);
}

// The gap of 20 mm is wider than any alpha that is taken from the scan, and narrower than 30 mm.
TEST(MeshSegmentation, TakesTheAlphaThatTheOptionsName) {
  const SegmentObjects objects = ScanObjects(TwoBoxes(0.020), 6);
  SegmentOptions options;
  EXPECT_EQ(SegmentByMesh(objects.cloud.points, options).size(), 2u);
  options.alpha_m = 0.030;
  EXPECT_EQ(SegmentByMesh(objects.cloud.points, options).size(), 1u);
}

TEST(Segment, RefusesAlphasOutOfRange) {
  SegmentOptions negative;
  negative.alpha_m = -0.001;
  SegmentOptions crossed;
  crossed.min_alpha_m = 0.02;
  crossed.max_alpha_m = 0.01;
  for (const SegmentOptions& options : {negative, crossed}) {
    EXPECT_THROW(SegmentByMesh(Points{}, options), std::invalid_argument);
    EXPECT_THROW(SegmentByRegionGrowing(Points{}, Points{}, options), std::invalid_argument);
  }
}

TEST(MeshSegmentation, OneStragglerDoesNotJoinWhatIsApart) {
  SegmentObjects objects = ScanObjects(TwoBoxes(0.030), 5);
  objects.cloud.points.emplace_back(0.0, 0.0, 0.3);  // d_max = 0.2 m
  EXPECT_EQ(SegmentByMesh(objects.cloud.points, {}).size(), 2u);
}

}  // namespace
}  // namespace rangegrasp::perception
