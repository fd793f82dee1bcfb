#include "pcl_bridge/local_convexity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "geometry/synthetic.h"
#include "noisy_surfaces.h"

namespace rangegrasp::pcl_bridge {
namespace {

using synthetic::Box;

class SeededConvexity : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededConvexity, ::testing::Range<std::uint64_t>(0, 10));

/// The solids without the table.
synthetic::Scan MakeScan(const std::vector<synthetic::Solid>& solids, std::uint64_t seed) {
  synthetic::ScanOptions options;
  options.table_half = {0.001, 0.001};  // under the solids: hidden
  options.seed = seed;
  return synthetic::MakeScan(solids, options);
}

Cloud ToCloud(const synthetic::Scan& scan) {
  return Cloud(scan.points_W, synthetic::ScanOptions{}.sensor_W);
}

/// How many points of each solid are in each segment.
std::map<int, std::map<int, int>> Shared(const synthetic::Scan& scan,
                                         const std::vector<std::int32_t>& segment) {
  std::map<int, std::map<int, int>> shared;
  for (std::size_t i = 0; i < segment.size(); ++i) ++shared[scan.label[i]][segment[i]];
  return shared;
}

/// The segment with the most points of it, and their share.
std::pair<int, double> MainSegment(const std::map<int, int>& segments) {
  int sum = 0;
  for (const auto& [segment, count] : segments) sum += count;
  const auto best = std::ranges::max_element(segments, {}, [](const auto& s) { return s.second; });
  return {best->first, static_cast<double>(best->second) / sum};
}

// Half a supervoxel (10 mm) beside the seam may go to the other side: 0.2 m of seam are 0.002 m2 of
// the 0.017 m2 that are seen of the upper box.
constexpr double kNearlyAll = 0.85;

TEST_P(SeededConvexity, AConvexBoxIsOneSegment) {
  const auto scan = MakeScan(
      {Box{{0, 0, 0.06}, {0.1, 0.08, 0.12}, 0.1 * static_cast<double>(GetParam())}}, GetParam());
  const auto [segment, share] =
      MainSegment(Shared(scan, SegmentByLocalConvexity(ToCloud(scan)).segment)[0]);
  EXPECT_GE(segment, 0);
  EXPECT_GT(share, kNearlyAll);
}

// A small box on a large one.
TEST_P(SeededConvexity, TouchingBoxesComeApartAtTheirConcaveEdges) {
  const double yaw = 0.06 * static_cast<double>(GetParam());
  const auto scan = MakeScan(
      {Box{{0, 0, 0.03}, {0.16, 0.16, 0.06}, 0.0}, Box{{0, 0, 0.10}, {0.07, 0.07, 0.08}, yaw}},
      GetParam());
  auto shared = Shared(scan, SegmentByLocalConvexity(ToCloud(scan)).segment);
  const auto [lower, lower_share] = MainSegment(shared[0]);
  const auto [upper, upper_share] = MainSegment(shared[1]);
  EXPECT_NE(lower, upper);
  EXPECT_GT(lower_share, kNearlyAll);
  EXPECT_GT(upper_share, kNearlyAll);
}

// The same surface seen from the other side: what was concave is convex.
TEST(Convexity, IsSeenFromTheCloudsOrigin) {
  base::Rng rng(1);
  auto points = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), 0.05, 0.0001, 8000, rng);
  samples::Append(
      samples::OnSquare({0.05, 0, 1.05}, Eigen::Vector3d::UnitX(), 0.05, 0.0001, 8000, rng),
      points);
  const LocalConvexityOptions options{.voxel_m = 0.004, .seed_m = 0.012};
  EXPECT_GE(SegmentByLocalConvexity(Cloud(points, {-1.0, 0.0, 2.0}), options).segments, 2);
  EXPECT_EQ(SegmentByLocalConvexity(Cloud(points, {1.0, 0.0, 0.0}), options).segments, 1);
}

TEST_P(SeededConvexity, LabelsCentersAndEdgesAgreeWithEachOther) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  options.outliers = 20;
  const auto scan = synthetic::MakeScan(synthetic::MixedObjects(), options);
  const LocalConvexity found = SegmentByLocalConvexity(ToCloud(scan));
  const auto supervoxels = static_cast<std::int32_t>(found.supervoxels.size());
  ASSERT_EQ(found.segment.size(), scan.points_W.size());
  ASSERT_EQ(found.supervoxel.size(), scan.points_W.size());
  std::set<std::int32_t> used;
  for (std::size_t i = 0; i < found.segment.size(); ++i) {
    ASSERT_GE(found.supervoxel[i], -1);
    ASSERT_LT(found.supervoxel[i], supervoxels);
    ASSERT_EQ(found.segment[i] < 0, found.supervoxel[i] < 0);
    if (found.segment[i] < 0) continue;
    const Supervoxel& s = found.supervoxels[static_cast<std::size_t>(found.supervoxel[i])];
    EXPECT_EQ(found.segment[i], s.segment);
    // A supervoxel grows for 1.8 seed sizes of voxel steps, each at most a voxel's diagonal long.
    EXPECT_LT((scan.points_W[i] - s.center).norm(),
              2.0 * 1.8 * LocalConvexityOptions{}.seed_m * std::sqrt(3.0));
    used.insert(found.segment[i]);
  }
  EXPECT_EQ(static_cast<int>(used.size()), found.segments);
  EXPECT_EQ(*used.rbegin(), found.segments - 1);
  for (const auto& edge : found.edges) {
    ASSERT_GE(edge.a, 0);
    ASSERT_LT(edge.a, edge.b);
    ASSERT_LT(edge.b, supervoxels);
    if (edge.connects) {
      EXPECT_EQ(found.supervoxels[static_cast<std::size_t>(edge.a)].segment,
                found.supervoxels[static_cast<std::size_t>(edge.b)].segment);
    }
  }
}

// A segment that has a neighbor is larger than min_supervoxels, and with 0 none is joined: then the
// segments are the components of the edges that connect.
TEST_P(SeededConvexity, SmallSegmentsJoinANeighbor) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  const Cloud cloud = ToCloud(synthetic::MakeScan(synthetic::MixedObjects(), options));
  const auto check = [](const LocalConvexity& found, int min) {
    std::map<std::int32_t, int> size;
    for (const auto& s : found.supervoxels) ++size[s.segment];
    int small = 0;
    for (const auto& e : found.edges) {
      const auto a = found.supervoxels[static_cast<std::size_t>(e.a)].segment;
      const auto b = found.supervoxels[static_cast<std::size_t>(e.b)].segment;
      if (a != b) small += size[a] <= min || size[b] <= min ? 1 : 0;
    }
    return small;
  };
  const LocalConvexity apart = SegmentByLocalConvexity(cloud, {.min_supervoxels = 0});
  EXPECT_GT(check(apart, 5), 0);
  const LocalConvexity joined = SegmentByLocalConvexity(cloud, {.min_supervoxels = 5});
  EXPECT_EQ(check(joined, 5), 0);
  EXPECT_LT(joined.segments, apart.segments);
  // Joining only joins.
  std::map<std::int32_t, std::set<std::int32_t>> into;
  for (std::size_t i = 0; i < apart.supervoxels.size(); ++i) {
    into[apart.supervoxels[i].segment].insert(joined.supervoxels[i].segment);
  }
  for (const auto& [segment, targets] : into) EXPECT_EQ(targets.size(), 1u) << segment;
}

// The library orders segments by the addresses of graph nodes. Here the free list of the heap is
// shuffled between two calls, so that addresses come in another order.
TEST_P(SeededConvexity, TheHeapsOrderDoesNotShow) {
  synthetic::ScanOptions options;
  options.seed = GetParam();
  options.sigma_m = 0.001;  // many small segments
  const Cloud cloud = ToCloud(synthetic::MakeScan(synthetic::MixedObjects(), options));
  const LocalConvexity first = SegmentByLocalConvexity(cloud);
  EXPECT_GE(first.segments, 5);  // the objects' number
  base::Rng rng(GetParam());
  for (int again = 0; again < 3; ++again) {
    std::vector<std::unique_ptr<char[]>> blocks;
    for (int i = 0; i < 50000; ++i)
      blocks.push_back(std::make_unique<char[]>(16 + 16 * rng.Index(16)));
    for (const auto i : geometry::samples::Permutation(blocks.size(), rng)) {
      if (i % 2 == 0) blocks[i].reset();
    }
    const LocalConvexity other = SegmentByLocalConvexity(cloud);
    EXPECT_EQ(other.segments, first.segments);
    EXPECT_EQ(other.segment, first.segment);
    EXPECT_EQ(other.supervoxel, first.supervoxel);
  }
}

// Twice as far away and twice as large: a camera sees the same.
TEST(Convexity, WithCameraDepthVoxelsGrowWithTheDepth) {
  base::Rng rng(2);
  const auto near = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), 0.1, 0.0, 4000, rng);
  geometry::Points far;
  for (const auto& p : near) far.push_back(4.0 * p);
  // At 4 m points are 13 mm apart: voxels of 10 mm lose touch with each other.
  LocalConvexityOptions options{.voxel_m = 0.01, .seed_m = 0.08, .min_supervoxels = 0};
  EXPECT_GT(SegmentByLocalConvexity(Cloud(far), options).segments, 1);
  options.camera_depth = true;
  EXPECT_EQ(SegmentByLocalConvexity(Cloud(far), options).segments, 1);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
