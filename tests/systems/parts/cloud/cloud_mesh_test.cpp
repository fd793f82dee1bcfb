#include "parts/cloud/cloud_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include "parts/cloud/cloud_samples.h"
#include "parts/shape/shape.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using Faces = std::vector<std::array<std::uint32_t, 3>>;

/// A heap with many blocks of all small sizes, half of them freed in random order. Later
/// allocations land in scattered holes.
class PerturbedHeap {
 public:
  explicit PerturbedHeap(std::uint64_t seed) {
    constexpr std::size_t kBlocks = 50'000;
    base::Rng rng(seed);
    for (std::size_t k = 0; k < kBlocks; ++k) {
      blocks_.push_back(std::make_unique<std::byte[]>(16 + rng.Index(1000)));
    }
    for (std::size_t k = kBlocks; k > 1; --k) std::swap(blocks_[k - 1], blocks_[rng.Index(k)]);
    blocks_.resize(kBlocks / 2);
  }

 private:
  std::vector<std::unique_ptr<std::byte[]>> blocks_;
};

/// Lattice points on the faces of a cube: all triangles have the same size.
geometry::Points LatticeCube() {
  constexpr int kSide = 12;
  geometry::Points points;
  for (int x = 0; x <= kSide; ++x) {
    for (int y = 0; y <= kSide; ++y) {
      for (int z = 0; z <= kSide; ++z) {
        if (x % kSide == 0 || y % kSide == 0 || z % kSide == 0) points.emplace_back(x, y, z);
      }
    }
  }
  return points;
}

/// Half a ball: its open edges stay unclosed until the largest gaps are meshed.
geometry::Points HalfBall() {
  base::Rng rng(3);
  geometry::Points points;
  while (points.size() < 2'000) {
    points.push_back(samples::BallPoint(rng));
    if (points.back().z() < 0.0) points.pop_back();
  }
  return points;
}

class AnyHeap : public ::testing::TestWithParam<std::pair<geometry::Points, double>> {};

TEST_P(AnyHeap, GivesTheSameTriangles) {
  const auto& [points, max_edge] = GetParam();
  const Faces first = AdvancingFront(points, max_edge);
  ASSERT_GT(first.size(), points.size());
  for (const std::uint64_t seed : {1, 2}) {
    const PerturbedHeap heap(seed);
    EXPECT_EQ(AdvancingFront(points, max_edge), first);
    Faces of_thread;  // this thread uses another heap
    std::thread([&] {
      const PerturbedHeap own(seed + 10);
      of_thread = AdvancingFront(points, max_edge);
    }).join();
    EXPECT_EQ(of_thread, first);
  }
}
// Six spacings, as in cloud meshing; for 2,000 points on half a ball one is root(pi / 1000).
INSTANTIATE_TEST_SUITE_P(Clouds, AnyHeap,
                         ::testing::Values(std::pair(LatticeCube(), 6.0),
                                           std::pair(HalfBall(), 0.336)));

using Eigen::Vector3d;
using samples::BallPoint;
using samples::Noisy;

/// `count` points of the unit ball with noise.
geometry::Points BallCloud(int count, double noise, std::uint64_t seed) {
  base::Rng rng(seed);
  geometry::Points points;
  for (int k = 0; k < count; ++k) points.push_back(Noisy(BallPoint(rng), noise, rng));
  return points;
}

TEST(CloudSampling, NoiseAndSpacingAreMeasured) {
  for (const int count : {3'000, 20'000}) {
    // Uniformly drawn points each represent an equal share of the ball.
    const double spacing = std::sqrt(4.0 * std::numbers::pi / count);
    for (const double noises : {0.1, 0.5, 2.0}) {
      const double noise = noises * spacing;
      const geometry::Points points = BallCloud(count, noise, 5);
      const CloudSampling sampling = MeasureSampling(points, geometry::KdTree(points));
      EXPECT_NEAR(sampling.noise, noise, 0.15 * noise) << count << " " << noises;
      EXPECT_NEAR(sampling.spacing, spacing, 0.15 * spacing) << count << " " << noises;
    }
  }
}

TEST(CloudSampling, PointsFarFromTheSurfaceAreStrays) {
  geometry::Points points = BallCloud(5'000, 0.01, 2);
  base::Rng rng(3);
  for (int k = 0; k < 20; ++k) points.push_back(rng.Uniform(1.5, 4.0) * BallPoint(rng));
  const geometry::KdTree tree(points);
  const std::vector<bool> stray = StrayPoints(points, tree, MeasureSampling(points, tree));
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(stray[i], i >= 5'000) << i;
}

class CloudMeshOfBall : public ::testing::TestWithParam<std::pair<int, double>> {};

TEST_P(CloudMeshOfBall, IsClosedRoundAndTurnedOutwards) {
  const auto [count, noise] = GetParam();
  const geometry::Points points = BallCloud(count, noise, 7);
  const CloudMesh found = MeshOfCloud(points);
  const Shape& mesh = found.mesh;
  // Each face has three neighbors, except at the few pinholes that the front leaves.
  EXPECT_NEAR(static_cast<double>(BuildFaceGraph(mesh).neighbor.size()) / 3.0,
              static_cast<double>(mesh.faces.size()),
              1e-3 * static_cast<double>(mesh.faces.size()));
  const FaceFrames frames = BuildFaceFrames(mesh);
  Vector3d middle = Vector3d::Zero();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    middle += frames.area[f] / frames.total_area * frames.center[f];
  }
  double radius = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    radius += frames.area[f] / frames.total_area * (frames.center[f] - middle).norm();
  }
  double outwards = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    outwards +=
        frames.area[f] / frames.total_area * frames.normal[f].dot(frames.center[f] - middle);
  }
  // Smoothing aims at normals with a slope error of 0.1 rad about two axes, so that the area is 1 %
  // larger and the mean cosine 1 % smaller. The tolerance is three times that.
  EXPECT_NEAR(frames.total_area / (4.0 * std::numbers::pi * radius * radius), 1.0, 0.03);
  EXPECT_GT(outwards / radius, 0.97);
  EXPECT_EQ(found.face_of_point.size(), points.size());
}
INSTANTIATE_TEST_SUITE_P(Grades, CloudMeshOfBall,
                         ::testing::Values(std::pair(2'000, 0.0), std::pair(10'000, 0.0),
                                           std::pair(10'000, 0.02), std::pair(40'000, 0.02)));

TEST(CloudMesh, APointBelongsToAFaceBesideIt) {
  const geometry::Points points = BallCloud(3'000, 0.0, 11);
  const CloudMesh found = MeshOfCloud(points);
  const FaceFrames frames = BuildFaceFrames(found.mesh);
  // Two nearby points have nearby faces. Distances are in the mesh's unit, in which the ball's
  // radius is about 1 too.
  for (std::size_t i = 1; i < 200; ++i) {
    const double apart = (points[i] - points[0]).norm();
    const double of_faces =
        (frames.center[found.face_of_point[i]] - frames.center[found.face_of_point[0]]).norm();
    EXPECT_NEAR(of_faces, apart, 0.15);
  }
}

TEST(CloudMesh, PointsThatAreNoSurfaceHaveNoFaces) {
  const geometry::Points corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_TRUE(MeshOfCloud(corners).mesh.faces.empty());
}

}  // namespace
}  // namespace rangegrasp::parts
