#include "geometry/groups.h"

#include <gtest/gtest.h>

namespace rangegrasp::geometry {
namespace {

// Chains along x, whose points take turns: a link holds at its length and not beyond, a chain is
// one group however long, and groups and points keep their order.
TEST(GroupsWithin, AreChainsOfLinksInTheOrderOfTheirFirstPoints) {
  Points points;
  for (int i = 0; i < 20; ++i) {
    points.emplace_back(0.9 * i, 100.0, 0.0);
    points.emplace_back(0.9 * i, 0.0, 0.0);
  }
  points.emplace_back(0.0, 1.1, 0.0);
  const auto groups = GroupsWithin(points, 1.0);
  ASSERT_EQ(groups.size(), 3u);
  ASSERT_EQ(groups[0].size(), 20u);
  ASSERT_EQ(groups[1].size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(groups[0][i], points[2 * i]);
    EXPECT_EQ(groups[1][i], points[2 * i + 1]);
  }
  EXPECT_EQ(groups[2], (Points{points.back()}));
  EXPECT_EQ(GroupsWithin(points, 1.2).size(), 2u);
}

TEST(GroupsWithin, NoPointsAreNoGroups) { EXPECT_TRUE(GroupsWithin({}, 1.0).empty()); }

}  // namespace
}  // namespace rangegrasp::geometry
