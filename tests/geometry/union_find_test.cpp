#include "geometry/union_find.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace rangegrasp::geometry {
namespace {

// Against labels that are all rewritten at every union.
TEST(UnionFind, JoinsAsRelabellingDoes) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    base::Rng rng(seed);
    constexpr std::uint32_t n = 40;
    UnionFind sets(n);
    std::vector<std::uint32_t> label(n);
    for (std::uint32_t i = 0; i < n; ++i) label[i] = i;
    for (int k = 0; k < 60; ++k) {
      const auto a = static_cast<std::uint32_t>(rng.Index(n));
      const auto b = static_cast<std::uint32_t>(rng.Index(n));
      EXPECT_EQ(sets.Unite(a, b), label[a] != label[b]);
      const std::uint32_t from = label[b];
      for (std::uint32_t& l : label) l = l == from ? label[a] : l;
      for (std::uint32_t i = 0; i < n; ++i) {
        EXPECT_EQ(sets.Find(i) == sets.Find(a), label[i] == label[a]);
      }
    }
  }
}

TEST(LabelBySize, NumbersTheUsedMembersLargestFirstTiesByFirstMember) {
  UnionFind sets(9);
  for (const auto& [a, b] : {std::pair(7u, 1u), {2u, 3u}, {3u, 8u}, {4u, 5u}}) sets.Unite(a, b);
  std::vector<std::int32_t> label;
  // {2, 3, 8} has one used member left, {1, 7} and {4, 5} have two, {0} and {6} are alone.
  const std::vector<bool> used{true, true, true, false, true, true, false, true, false};
  EXPECT_EQ(LabelBySize(sets, used, label), 4);
  EXPECT_EQ(label, (std::vector<std::int32_t>{2, 0, 3, -1, 1, 1, -1, 0, -1}));
}

}  // namespace
}  // namespace rangegrasp::geometry
