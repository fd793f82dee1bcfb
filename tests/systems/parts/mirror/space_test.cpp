#include "parts/mirror/internal/space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "base/rng.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

// The cell knows its direction: the face of the cube that it leaves through, and where on it.
TEST(CubeCell, HoldsDirectionsThatLeaveTheCubeCloseTogether) {
  constexpr int kSide = 5;
  base::Rng rng(1);
  std::set<std::size_t> cells;
  std::vector<Vector3d> first(6 * kSide * kSide, Vector3d::Zero());
  for (int i = 0; i < 20000; ++i) {
    const Vector3d d(rng.Normal(), rng.Normal(), rng.Normal());
    const std::size_t cell = CubeCell(d, kSide);
    ASSERT_LT(cell, first.size());
    EXPECT_EQ(CubeCell(rng.Uniform(0.1, 10.0) * d, kSide), cell);
    const Vector3d on_cube = d / d.cwiseAbs().maxCoeff();
    if (!cells.insert(cell).second) {
      // A cell is 2 / side wide and lies in one face.
      EXPECT_LE((on_cube - first[cell]).cwiseAbs().maxCoeff(), 2.0 / kSide + 1e-12);
    } else {
      first[cell] = on_cube;
    }
  }
  EXPECT_EQ(cells.size(), first.size());
  EXPECT_EQ(CubeCell(Vector3d::Zero(), kSide), 0U);
}

// Reference: of two points that comes first whose coordinates differ at the higher bit, in the
// order z, y, x, looked at bit by bit.
TEST(SpatialOrder, IsThatOfInterleavedBits) {
  base::Rng rng(2);
  geometry::Points points = {Vector3d(0, 0, 0), Vector3d(1, 1, 1)};  // the box of all
  for (int i = 0; i < 500; ++i) points.emplace_back(rng.Uniform(), rng.Uniform(), rng.Uniform());
  const auto order = SpatialOrder(points);
  std::vector<std::uint32_t> all(points.size());
  std::iota(all.begin(), all.end(), 0U);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    for (int bit = 20; bit >= 0; --bit) {
      for (const int axis : {2, 1, 0}) {
        const auto digit = [&](std::uint32_t i) {
          return static_cast<std::uint64_t>(points[i][axis] * 2097151.0) >> bit & 1U;
        };
        if (digit(a) != digit(b)) return digit(a) < digit(b);
      }
    }
    return a < b;
  };
  std::sort(all.begin(), all.end(), before);
  EXPECT_EQ(order, all);
  EXPECT_TRUE(SpatialOrder({}).empty());
  EXPECT_EQ(SpatialOrder(geometry::Points(3, Vector3d(1, 2, 3))),
            (std::vector<std::uint32_t>{0, 1, 2}));
}

}  // namespace
}  // namespace rangegrasp::parts
