#include "geometry/adjacency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rangegrasp::geometry {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<std::pair<std::uint32_t, std::uint32_t>> kEdges = {{2, 1}, {0, 3}, {2, 0},
                                                                     {0, 1}, {2, 1}, {0, 3}};

TEST(Adjacency, EachNodeHasTheEndsOfItsEdgesInTheirOrder) {
  const Adjacency adjacency = MakeAdjacency(kEdges, 4);
  ASSERT_EQ(adjacency.nodes(), 4u);
  EXPECT_THAT(adjacency.Of(0), ElementsAre(3, 1, 3));
  EXPECT_THAT(adjacency.Of(1), IsEmpty());
  EXPECT_THAT(adjacency.Of(2), ElementsAre(1, 0, 1));
  EXPECT_THAT(adjacency.Of(3), IsEmpty());
}

TEST(Adjacency, UniqueEndsAreAscending) {
  const Adjacency adjacency = Unique(MakeAdjacency(kEdges, 4));
  EXPECT_THAT(adjacency.Of(0), ElementsAre(1, 3));
  EXPECT_THAT(adjacency.Of(1), IsEmpty());
  EXPECT_THAT(adjacency.Of(2), ElementsAre(0, 1));
  EXPECT_THAT(adjacency.Of(3), IsEmpty());
  EXPECT_EQ(adjacency.to.size(), 4u);
}

TEST(Adjacency, OfNothingHasNoNodes) {
  EXPECT_EQ(Adjacency().nodes(), 0u);
  EXPECT_EQ(Unique(MakeAdjacency({}, 0)).nodes(), 0u);
}

}  // namespace
}  // namespace rangegrasp::geometry
