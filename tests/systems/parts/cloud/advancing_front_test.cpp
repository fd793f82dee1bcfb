#include "parts/cloud/internal/advancing_front.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "parts/cloud/cloud_samples.h"

namespace rangegrasp::parts {
namespace {

using Faces = std::vector<std::array<std::uint32_t, 3>>;

/// The heap with so many blocks of all small sizes taken, and half of them given back in a random
/// order: what is made next lies in the holes, one here and one there.
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

/// A lattice's points on the faces of a cube: all triangles are as large as each other.
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

/// Half a ball: its edges wait for wider gaps until the last.
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
    Faces of_thread;  // whose heap is another one
    std::thread([&] {
      const PerturbedHeap own(seed + 10);
      of_thread = AdvancingFront(points, max_edge);
    }).join();
    EXPECT_EQ(of_thread, first);
  }
}
// Six spacings, as clouds are meshed: of half a ball's 2,000 points one is root(pi / 1000).
INSTANTIATE_TEST_SUITE_P(Clouds, AnyHeap,
                         ::testing::Values(std::pair(LatticeCube(), 6.0),
                                           std::pair(HalfBall(), 0.336)));

}  // namespace
}  // namespace rangegrasp::parts
