#include "base/count_to_beat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/rng.h"

namespace rangegrasp::base {
namespace {

// Against a plain count: the same wherever it is larger than what is to be beaten, and not larger
// where the plain count is not.
TEST(CountToBeat, IsTheCountWhereThatIsLarger) {
  Rng rng(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<int> items(rng.Index(300));
    for (int& item : items) item = static_cast<int>(rng.Index(4));
    const auto is_zero = [](int item) { return item == 0; };
    const auto all = static_cast<std::size_t>(std::ranges::count_if(items, is_zero));
    for (const std::size_t to_beat : {std::size_t{0}, all / 2, all, all + 1}) {
      const std::size_t count = CountToBeat(items, to_beat, is_zero);
      if (all > to_beat) {
        EXPECT_EQ(count, all);
      } else {
        EXPECT_LE(count, to_beat);
      }
    }
  }
}

TEST(CountToBeat, LooksAtFewItemsWhereTheCountIsOutOfReach) {
  const std::vector<int> items(10000, 1);
  int looked_at = 0;
  CountToBeat(items, 9000, [&](int item) {
    ++looked_at;
    return item == 0;
  });
  EXPECT_LT(looked_at, 1100) << "a tenth of them, and a block";
}

}  // namespace
}  // namespace rangegrasp::base
