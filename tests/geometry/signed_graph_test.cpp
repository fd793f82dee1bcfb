#include "geometry/signed_graph.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace rangegrasp::geometry {
namespace {

TEST(ContractGreedily, AFewEdgesForDoNotOutvoteTheBorderAgainst) {
  // Two pairs; one edge between them speaks for, and the rest of their border against.
  const std::vector<SignedEdge> edges = {
      {0, 1, 5.0}, {2, 3, 5.0}, {1, 2, 1.0}, {0, 2, -2.0}, {1, 3, -2.0}};
  UnionFind parts = ContractGreedily(4, edges);
  EXPECT_EQ(parts.Find(0), parts.Find(1));
  EXPECT_EQ(parts.Find(2), parts.Find(3));
  EXPECT_NE(parts.Find(0), parts.Find(2));
}

TEST(ContractGreedily, ParallelEdgesAreSummed) {
  UnionFind apart = ContractGreedily(2, std::vector<SignedEdge>{{0, 1, 1.0}, {1, 0, -1.5}});
  EXPECT_NE(apart.Find(0), apart.Find(1));
  UnionFind joined = ContractGreedily(2, std::vector<SignedEdge>{{0, 1, 1.0}, {1, 0, -0.5}});
  EXPECT_EQ(joined.Find(0), joined.Find(1));
}

TEST(ContractGreedily, NamesWhatIsNoEdge) {
  EXPECT_THROW(ContractGreedily(2, std::vector<SignedEdge>{{0, 2, 1.0}}), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ContractGreedily(2, std::vector<SignedEdge>{{0, 1, nan}}), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::geometry
