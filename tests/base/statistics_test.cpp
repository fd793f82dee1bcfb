#include "base/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/rng.h"

namespace rangegrasp::base {
namespace {

TEST(Quantile, OfKnownValues) {
  const std::vector<double> four = {40.0, 10.0, 30.0, 20.0};
  EXPECT_EQ(QuantileOf(four, 0.0), 10.0);
  EXPECT_EQ(QuantileOf(four, 0.5), 20.0);  // floor(0.5 * 3) = 1
  EXPECT_EQ(QuantileOf(four, 1.0), 40.0);
  EXPECT_EQ(UpperMedianOf(four), 30.0);
  EXPECT_EQ(MedianOf(four), 25.0);
  EXPECT_EQ(InterpolatedQuantileOf(four, 0.25), 17.5);  // position 0.75 between 10 and 20
  EXPECT_EQ(InterpolatedQuantileOf(std::vector<double>{3.0}, 0.95), 3.0);
  EXPECT_EQ(UpperMedianOf(std::vector<int>{5}), 5);
}

// Compares with a sort, for any order and with ties.
TEST(Quantile, AgreesWithASort) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Rng rng(seed);
    std::vector<double> values(1 + rng.Index(12));
    for (double& value : values) value = static_cast<double>(rng.Index(6));
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const double share = rng.Uniform();
    const double position = share * static_cast<double>(sorted.size() - 1);
    const auto low = static_cast<std::size_t>(position);
    const std::size_t high = std::min(low + 1, sorted.size() - 1);
    EXPECT_EQ(QuantileOf(values, share), sorted[low]);
    EXPECT_EQ(UpperMedianOf(values), sorted[sorted.size() / 2]);
    EXPECT_NEAR(InterpolatedQuantileOf(values, share),
                sorted[low] + (position - static_cast<double>(low)) * (sorted[high] - sorted[low]),
                1e-12);
  }
}

// Compares with a plain count: equal to it if it exceeds the count to beat, otherwise not above
// the count to beat.
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
