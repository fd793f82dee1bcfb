#include "parts/hierarchy/internal/cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/units.h"
#include "parts/hierarchy/internal/cells.h"

namespace rangegrasp::parts {
namespace {

std::shared_ptr<Sight> SightOf(std::uint32_t cells, bool (*sees)(std::uint32_t, std::uint32_t)) {
  std::vector<std::vector<bool>> all(cells);
  for (std::uint32_t a = 0; a < cells; ++a) {
    for (std::uint32_t b = 0; b < cells; ++b) all[a].push_back(sees(a, b));
  }
  return std::make_shared<Sight>(all);
}

/// A row of cells that all see each other. It counts as a solid lump because all normals point away
/// from the middle of the row.
/// @param ring  the last cell touches the first
Cells Row(const std::vector<double>& areas, const std::vector<double>& borders, bool ring = false) {
  Cells cells;
  const auto count = static_cast<std::uint32_t>(areas.size());
  cells.area = areas;
  cells.on_edge.assign(count, 0);
  cells.begin = {0};
  cells.sight = SightOf(count, [](std::uint32_t, std::uint32_t) { return true; });
  for (std::uint32_t c = 0; c < count; ++c) {
    cells.name.push_back(c);
    cells.center.emplace_back(c, 0.0, 0.0);
    cells.normal.push_back(Eigen::Vector3d::UnitX());
    const auto touch = [&](std::uint32_t to, double border) {
      cells.neighbor.push_back(to);
      cells.border.push_back({border, border});
    };
    if (ring && c + 1 == count) touch(0, 1.0);
    if (c > 0) touch(c - 1, borders[c - 1]);
    if (c + 1 < count) touch(c + 1, borders[c]);
    if (ring && c == 0) touch(count - 1, 1.0);
    cells.begin.push_back(static_cast<std::uint32_t>(cells.neighbor.size()));
  }
  return cells;
}

Sides FirstCells(std::size_t n, std::size_t count) {
  Sides set(n, 0);
  std::fill(set.begin(), set.begin() + static_cast<std::ptrdiff_t>(count), 1);
  return set;
}

// Any solidity is accepted, because all normals of a row point the same way; any flatness, too.
const HierarchyOptions kAnySide{.solidity = -1e9, .max_flatness = 1e9};

TEST(BestSplit, IsTheCheapestBorderForTheGirthOfTheSmallerSide) {
  const Cells row = Row({1, 1, 1, 1, 1, 1}, {5, 2, 3, 1, 5});
  std::vector<Sides> candidates;
  for (std::size_t k = 1; k < 6; ++k) candidates.push_back(FirstCells(6, k));
  const CutOff best = BestSplit(row, candidates, 0.5, kAnySide);
  // Cuts cost 5, 2, 3, 1, 5; smaller sides are 1, 2, 3, 2, 1: the fourth cut is clearly the best.
  EXPECT_NEAR(best.quality, 1.0 / std::sqrt(4.0 * base::kPi * 2.0), 1e-12);
  EXPECT_TRUE(best.off == (Indices{0, 1, 2, 3}) || best.off == (Indices{4, 5}));
  // Sides of two cells are too small here, so only the middle cut is left.
  const CutOff middle = BestSplit(row, candidates, 2.5, kAnySide);
  EXPECT_NEAR(middle.quality, 3.0 / std::sqrt(4.0 * base::kPi * 3.0), 1e-12);
  EXPECT_TRUE(std::isinf(BestSplit(row, candidates, 3.5, kAnySide).quality));
  // No set of cells is solid enough.
  EXPECT_TRUE(std::isinf(BestSplit(row, candidates, 0.5, {.solidity = 1e9}).quality));
}

// Two rooms in a row of eight cells, with a wall between the fourth and the fifth cell: no pair
// across the wall sees each other, all pairs in a room do. Across a cut elsewhere, cells see each
// other up to the end of their room.
TEST(SeenAcross, IsLeastWhereRoomsMeet) {
  Cells row = Row(std::vector<double>(8, 1.0), std::vector<double>(7, 1.0));
  row.sight = SightOf(8, [](std::uint32_t a, std::uint32_t b) { return (a < 4) == (b < 4); });
  EXPECT_EQ(SeenAcross(row, FirstCells(8, 4), 10.0), 0.1);
  EXPECT_EQ(SeenAcross(row, FirstCells(8, 2), 1.0), 1.0);
  row.sight = SightOf(8, [](std::uint32_t, std::uint32_t) { return true; });
  EXPECT_EQ(SeenAcross(row, FirstCells(8, 4), 10.0), 1.0);
}

// The function stops early only if the value is above the limit.
TEST(SeenAcross, IsTheSameBelowAnyLimit) {
  Cells row = Row(std::vector<double>(60, 1.0), std::vector<double>(59, 1.0));
  int stopped = 0;
  for (std::uint32_t wall = 5; wall < 56; ++wall) {
    row.sight = SightOf(60, [](std::uint32_t a, std::uint32_t b) { return (7 * a * b) % 10 < 6; });
    const Sides off = FirstCells(60, wall);
    const double value = SeenAcross(row, off, 20.0).value();
    for (double limit = 0.05; limit < 1.2; limit += 0.05) {
      const auto found = SeenAcross(row, off, 20.0, limit);
      stopped += !found;
      EXPECT_TRUE(found ? *found == value : value > limit) << wall << ", " << limit;
    }
  }
  EXPECT_GT(stopped, 100);
}

// Cells that are far apart see little of each other anyway, for example in a thin bent wall. This
// must not make a cut through the wall better.
TEST(SeenAcross, ComparesPairsThatAreAsFarApart) {
  Cells row = Row(std::vector<double>(40, 1.0), std::vector<double>(39, 1.0));
  row.sight = SightOf(40, [](std::uint32_t a, std::uint32_t b) { return a < b + 6 && b < a + 6; });
  // Bins of 15 / 8 mix pairs that see each other with pairs that do not: tolerance 0.1.
  EXPECT_NEAR(SeenAcross(row, FirstCells(40, 20), 6.0).value(), 1.0, 0.1);
}

TEST(Divide, CrumbsGoWithWhatIsTakenOff) {
  // Without cell 2 the row falls into {0, 1} and {3, 4, 5}; without cell 1, into {0} and the rest.
  const Cells row = Row({0.1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1});
  EXPECT_EQ(Divide(row, {2}, 0.5), (std::vector<Indices>{{0, 1}, {2}, {3, 4, 5}}));
  EXPECT_EQ(Divide(row, {1}, 0.5), (std::vector<Indices>{{0, 1}, {2, 3, 4, 5}}));
  EXPECT_EQ(Divide(row, {1}, 0.05), (std::vector<Indices>{{0}, {1}, {2, 3, 4, 5}}));
}

TEST(Divide, TheLargestRestStaysHoweverSmall) {
  const Cells row = Row({1, 1, 2}, {1, 1});
  EXPECT_EQ(Divide(row, {1}, 10.0), (std::vector<Indices>{{0, 1}, {2}}));
}

// A row has one border between its ends, a ring has two. A border at an edge of an earlier cut does
// not count.
TEST(HandleLoops, CountsTheBordersThatCloseAHandle) {
  const Cells row = Row(std::vector<double>(16, 1.0), std::vector<double>(15, 1.0));
  const Sides off = FirstCells(16, 6);
  EXPECT_EQ(HandleLoops(row, off), 1.0);
  Cells ring = Row(std::vector<double>(16, 1.0), std::vector<double>(15, 1.0), true);
  EXPECT_EQ(HandleLoops(ring, off), 2.0);
  ring.on_edge[5] = 1;
  EXPECT_EQ(HandleLoops(ring, off), 1.0);
}

// Two borders of a ring cost as much as one handle: half of the cost in a row.
TEST(BestSplit, AHandleIsCutAtBothEndsForThePriceOfOne) {
  const Cells ring = Row(std::vector<double>(16, 1.0), std::vector<double>(15, 1.0), true);
  const CutOff split = BestSplit(ring, {FirstCells(16, 6)}, 0.5, kAnySide);
  EXPECT_NEAR(split.quality, 0.5 * 2.0 / std::sqrt(4.0 * base::kPi * 6.0), 1e-12);
}

TEST(ConnectedSets, AreThoseOfEachSide) {
  const Cells row = Row({1, 1, 1, 1, 1}, {1, 1, 1, 1});
  EXPECT_EQ(ConnectedSets(row, {1, 0, 0, 1, 1}), (std::vector<Indices>{{0}, {1, 2}, {3, 4}}));
}

// One edge of length 2, bent by b: the factor is e^-gb if concave, 1 + g / 4 |b| if convex.
TEST(BendCosts, AGrooveIsCheapAndARidgeIsDear) {
  Shape two;
  two.points = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -1, 0}};
  two.faces = {{0, 1, 2}, {1, 0, 3}};
  const FaceGraph faces = BuildFaceGraph(two);
  ASSERT_EQ(faces.neighbor.size(), 2U);
  for (const double bend : {0.3, 1.5}) {
    EXPECT_NEAR(BendCosts(two, faces, {bend, bend}, 2.0)[0], 2.0 * std::exp(-2.0 * bend), 1e-12);
    EXPECT_NEAR(BendCosts(two, faces, {-bend, -bend}, 2.0)[1], 2.0 * (1.0 + 0.5 * bend), 1e-12);
  }
  EXPECT_EQ(BendCosts(two, faces, {0.0, 0.0}, 2.0)[0], 2.0);
}

}  // namespace
}  // namespace rangegrasp::parts
