#include "pcl_bridge/pcl_segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "geometry/graph.h"
#include "geometry/synthetic.h"
#include "labelled_cloud.h"
#include "noisy_surfaces.h"
#include "surveys/separation.h"

namespace rangegrasp::pcl_bridge {
namespace {

class SeededClusters : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededClusters, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededClusters, EuclideanClustersAreTheComponentsOfPairsWithinTheTolerance) {
  base::Rng rng(GetParam());
  const auto points = geometry::samples::RandomPoints(400, 0.1, rng);
  const EuclideanClusterOptions options{.tolerance_m = 0.017, .min_points = 3};
  geometry::UnionFind sets(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (std::uint32_t j = 0; j < i; ++j) {
      if ((points[i] - points[j]).norm() < options.tolerance_m) sets.Unite(i, j);
    }
  }
  std::map<std::uint32_t, geometry::Indices> expected;
  for (std::uint32_t i = 0; i < points.size(); ++i) expected[sets.Find(i)].push_back(i);
  std::erase_if(expected, [](const auto& set) { return set.second.size() < 3; });
  auto clusters = EuclideanClusters(points, samples::kOrigin, options);
  EXPECT_TRUE(std::ranges::is_sorted(clusters, std::greater(), &geometry::Indices::size));
  std::vector<geometry::Indices> sorted;
  for (const auto& [root, set] : expected) sorted.push_back(set);
  std::ranges::sort(sorted);
  std::ranges::sort(clusters);
  EXPECT_GT(sorted.size(), 1u);
  EXPECT_EQ(clusters, sorted);
}

using synthetic::Box;

class SeededConvexity : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededConvexity, ::testing::Range<std::uint64_t>(0, 10));

/// A scan of the solids without the table.
synthetic::Scan MakeScan(const std::vector<synthetic::Solid>& solids, std::uint64_t seed) {
  synthetic::ScanOptions options;
  options.table_half = {0.001, 0.001};  // hidden under the solids
  options.seed = seed;
  return synthetic::MakeScan(solids, options);
}

std::vector<std::int32_t> Segmented(const synthetic::Scan& scan,
                                    const LocalConvexityOptions& options = {}) {
  return SegmentByLocalConvexity(scan.points_W, synthetic::ScanOptions{}.sensor_W, options);
}

/// Number of segments.
int CountOf(const std::vector<std::int32_t>& segment) { return std::ranges::max(segment) + 1; }

/// Number of points of each solid in each segment.
std::map<int, std::map<int, int>> Shared(const synthetic::Scan& scan,
                                         const std::vector<std::int32_t>& segment) {
  std::map<int, std::map<int, int>> shared;
  for (std::size_t i = 0; i < segment.size(); ++i) ++shared[scan.label[i]][segment[i]];
  return shared;
}

/// The segment with the most points of a solid, and its share of them.
std::pair<int, double> MainSegment(const std::map<int, int>& segments) {
  int sum = 0;
  for (const auto& [segment, count] : segments) sum += count;
  const auto best = std::ranges::max_element(segments, {}, [](const auto& s) { return s.second; });
  return {best->first, static_cast<double>(best->second) / sum};
}

// Half a supervoxel (10 mm) next to the seam may go to the other side: 0.2 m of seam are 0.002 m2
// of the upper box's visible 0.017 m2.
constexpr double kNearlyAll = 0.85;

TEST_P(SeededConvexity, AConvexBoxIsOneSegment) {
  const auto scan = MakeScan(
      {Box{{0, 0, 0.06}, {0.1, 0.08, 0.12}, 0.1 * static_cast<double>(GetParam())}}, GetParam());
  const auto [segment, share] = MainSegment(Shared(scan, Segmented(scan))[0]);
  EXPECT_GE(segment, 0);
  EXPECT_GT(share, kNearlyAll);
}

// A small box on a large one.
TEST_P(SeededConvexity, TouchingBoxesComeApartAtTheirConcaveEdges) {
  const double yaw = 0.06 * static_cast<double>(GetParam());
  const auto scan = MakeScan(
      {Box{{0, 0, 0.03}, {0.16, 0.16, 0.06}, 0.0}, Box{{0, 0, 0.10}, {0.07, 0.07, 0.08}, yaw}},
      GetParam());
  auto shared = Shared(scan, Segmented(scan));
  const auto [lower, lower_share] = MainSegment(shared[0]);
  const auto [upper, upper_share] = MainSegment(shared[1]);
  EXPECT_NE(lower, upper);
  EXPECT_GT(lower_share, kNearlyAll);
  EXPECT_GT(upper_share, kNearlyAll);
}

// The same surface seen from the other side: concave edges become convex.
TEST(Convexity, IsSeenFromTheCloudsOrigin) {
  base::Rng rng(1);
  auto points = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), 0.05, 0.0001, 8000, rng);
  const auto wall =
      samples::OnSquare({0.05, 0, 1.05}, Eigen::Vector3d::UnitX(), 0.05, 0.0001, 8000, rng);
  points.insert(points.end(), wall.begin(), wall.end());
  const LocalConvexityOptions options{.voxel_m = 0.004, .seed_m = 0.012};
  EXPECT_GE(CountOf(SegmentByLocalConvexity(points, {-1.0, 0.0, 2.0}, options)), 2);
  EXPECT_EQ(CountOf(SegmentByLocalConvexity(points, {1.0, 0.0, 0.0}, options)), 1);
}

TEST_P(SeededConvexity, SegmentsAreNumberedWithoutGaps) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  options.outliers = 20;
  const auto scan = synthetic::MakeScan(synthetic::MixedObjects(), options);
  const auto segment = Segmented(scan);
  ASSERT_EQ(segment.size(), scan.points_W.size());
  const std::set<std::int32_t> used(segment.begin(), segment.end());
  EXPECT_GE(*used.begin(), -1);
  EXPECT_EQ(CountOf(segment), static_cast<int>(used.size() - used.count(-1)));
}

// Joining small segments with their neighbors leaves fewer, and never splits one.
TEST_P(SeededConvexity, SmallSegmentsJoinANeighbor) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  const auto scan = synthetic::MakeScan(synthetic::MixedObjects(), options);
  const auto apart = Segmented(scan, {.min_supervoxels = 0});
  const auto joined = Segmented(scan, {.min_supervoxels = 5});
  EXPECT_LT(CountOf(joined), CountOf(apart));
  std::map<std::int32_t, std::set<std::int32_t>> into;
  for (std::size_t i = 0; i < apart.size(); ++i) into[apart[i]].insert(joined[i]);
  for (const auto& [segment, targets] : into) EXPECT_EQ(targets.size(), 1u) << segment;
}

// The library orders segments by the addresses of graph nodes. Here the heap's free list is
// shuffled between two calls, so that the order of the addresses changes.
TEST_P(SeededConvexity, TheHeapsOrderDoesNotShow) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  options.sigma_m = 0.001;  // many small segments
  const auto scan = synthetic::MakeScan(synthetic::MixedObjects(), options);
  const auto first = Segmented(scan);
  EXPECT_GE(CountOf(first), 5);  // the number of objects
  base::Rng rng(GetParam());
  for (int again = 0; again < 3; ++again) {
    std::vector<std::unique_ptr<char[]>> blocks;
    for (int i = 0; i < 50000; ++i)
      blocks.push_back(std::make_unique<char[]>(16 + 16 * rng.Index(16)));
    for (const auto i : geometry::samples::Permutation(blocks.size(), rng)) {
      if (i % 2 == 0) blocks[i].reset();
    }
    EXPECT_EQ(Segmented(scan), first);
  }
}

// Four times as far away and four times as large: a camera sees the same.
TEST(Convexity, WithCameraDepthVoxelsGrowWithTheDepth) {
  base::Rng rng(2);
  const auto near = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), 0.1, 0.0, 4000, rng);
  geometry::Points far;
  for (const auto& p : near) far.push_back(4.0 * p);
  // At 4 m the points are 13 mm apart: voxels of 10 mm are no longer adjacent.
  LocalConvexityOptions options{.voxel_m = 0.01, .seed_m = 0.08, .min_supervoxels = 0};
  EXPECT_GT(CountOf(SegmentByLocalConvexity(far, samples::kOrigin, options)), 1);
  options.camera_depth = true;
  EXPECT_EQ(CountOf(SegmentByLocalConvexity(far, samples::kOrigin, options)), 1);
}

using samples::RandomDirection;
using samples::RandomPoint;

constexpr double kSigma_m = 0.0003;

class SeededModels : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededModels, ::testing::Range<std::uint64_t>(0, 20));

// The library's refit (Levenberg-Marquardt in single precision, with numeric derivatives) stops
// before the least-squares optimum. The tolerance is therefore the noise of one point, while the
// optimum's standard error would be sigma / sqrt(n) = 6 um. For the axis direction, sigma acts on
// the lever half_length / sqrt(3).
TEST_P(SeededModels, CylinderIsTheTrueOneWithinItsStandardErrors) {
  base::Rng rng(GetParam());
  const samples::Tube tube{RandomPoint(0.2, rng), RandomDirection(rng), rng.Uniform(0.02, 0.05),
                           0.06};
  constexpr std::size_t kOnTube = 3000;
  geometry::Points points = samples::OnTube(tube, kSigma_m, kOnTube, rng);
  for (int i = 0; i < 300; ++i) points.push_back(tube.center + RandomPoint(0.15, rng));
  const Eigen::Vector3d sensor = tube.center + 1.0 * RandomDirection(rng);
  const auto fit = FitCylinder(points, sensor, EstimateNormals(points, sensor, 0.008));
  ASSERT_TRUE(fit);
  const CylinderFit& found = *fit;
  EXPECT_NEAR(found.radius_m, tube.radius_m, kSigma_m);
  EXPECT_NEAR(found.axis.norm(), 1.0, 1e-12);
  EXPECT_LT(found.axis.cross(tube.axis).norm(), std::sqrt(3.0) * kSigma_m / tube.half_length_m);
  EXPECT_LT((found.point - tube.center).cross(tube.axis).norm(), kSigma_m);
  // Along the axis: the mean of n uniform places has the error half_length / sqrt(3 n).
  EXPECT_LT(std::abs((found.point - tube.center).dot(tube.axis)),
            6.0 * tube.half_length_m / std::sqrt(3.0 * 0.8 * kOnTube));
  const auto on_tube =
      std::ranges::count_if(fit->inliers, [](std::uint32_t i) { return i < kOnTube; });
  EXPECT_GT(on_tube,
            0.8 * kOnTube);  // near ends and stray points the normals are off
}

/// Uses so few draws that the result depends on them.
std::optional<CylinderFit> FitWithFewDraws(std::uint64_t seed) {
  base::Rng rng(seed);
  const geometry::Points points = geometry::samples::RandomPoints(1000, 0.1, rng);
  const CylinderOptions wide{.max_draws = 3, .inlier_distance_m = 0.01, .max_radius_m = 1.0};
  return FitCylinder(points, samples::kOrigin, EstimateNormals(points, samples::kOrigin, 0.02),
                     wide);
}

// A generator seeded by the clock, as the library's can be, repeats only within a second.
TEST(Models, SamePointsGiveTheSameModelASecondLater) {
  constexpr std::uint64_t kClouds = 10;
  std::vector<std::optional<CylinderFit>> first;
  for (std::uint64_t seed = 0; seed < kClouds; ++seed) first.push_back(FitWithFewDraws(seed));
  EXPECT_TRUE(std::ranges::any_of(first, [](const auto& fit) { return fit.has_value(); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (std::uint64_t seed = 0; seed < kClouds; ++seed) {
    const auto again = FitWithFewDraws(seed);
    ASSERT_EQ(again.has_value(), first[seed].has_value());
    if (!again) continue;
    EXPECT_EQ(again->axis, first[seed]->axis);
    EXPECT_EQ(again->inliers, first[seed]->inliers);
  }
}

TEST(Models, CylinderKeepsToTheRadiiAskedFor) {
  base::Rng rng(3);
  const samples::Tube tube{{0, 0, 0.5}, Eigen::Vector3d::UnitX(), 0.03, 0.05};
  const geometry::Points points = samples::OnTube(tube, 0.0, 2000, rng);
  const geometry::Points normals = EstimateNormals(points, samples::kOrigin, 0.008);
  EXPECT_TRUE(
      FitCylinder(points, samples::kOrigin, normals, {.min_radius_m = 0.02, .max_radius_m = 0.04}));
  const auto large =
      FitCylinder(points, samples::kOrigin, normals, {.min_radius_m = 0.05, .max_radius_m = 0.1});
  EXPECT_TRUE(!large || large->inliers.size() < 1000u);
}

// Labeled clouds of a depth camera, if available: data/kinect in the folder given by
// RANGEGRASP_SHARED, or in ../shared next to the project.
TEST(Kinect, LocalConvexityFindsTheObjectsOfATable) {
  if (!std::filesystem::exists(labelled::KinectFolder())) {
    GTEST_SKIP() << "no labelled clouds in " << labelled::KinectFolder();
  }
  double sum = 0.0;
  const std::vector<int> numbers = {2, 20, 40};  // boxes, a stack, cylinders
  for (const int number : numbers) {
    const auto file = labelled::ReadKinect(number);
    // For a depth camera's spacing and noise: voxels of 7.5 mm at 1 m, seeds of 30 mm.
    const LocalConvexityOptions options{.voxel_m = 0.0075, .seed_m = 0.03, .camera_depth = true};
    const auto segment = SegmentByLocalConvexity(file.points, samples::kOrigin, options);
    const double overlap = surveys::Compare(file.labels, segment).overlap;
    RecordProperty("weighted_overlap_" + std::to_string(number), std::to_string(overlap));
    EXPECT_GT(overlap, 0.85) << "learn" << number;
    sum += overlap;
  }
  // Measured: 0.993, 0.956 and 0.941, with 3, 3 and 5 segments. The margin is for other versions.
  EXPECT_GT(sum / static_cast<double>(numbers.size()), 0.9);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
