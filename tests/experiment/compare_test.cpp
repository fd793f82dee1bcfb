#include "experiment/compare.h"

#include <gtest/gtest.h>

#include "experiment/sample_record.h"
#include "experiment/statistics.h"

namespace rangegrasp::experiment {
namespace {

Record With(int i, const char* outcome, std::uint64_t seed = 1) {
  Record record = SampleRecord("mug", i, seed);
  record.result.outcome = outcome;
  return record;
}

TEST(Compare, CountsPairsOfTheSameIdAndSeed) {
  const std::vector<Record> a = {With(0, "won"), With(1, "won"), With(2, "lost"), With(3, "lost"),
                                 With(4, "won")};
  const std::vector<Record> b = {With(3, "gone"), With(0, "won"),    With(1, "lost"),
                                 With(2, "won"),  With(4, "won", 2), With(9, "won")};
  const Comparison c = Compare(a, b, "won");
  EXPECT_EQ(c.pairs, 4);  // not 4, whose seed differs, and not 9
  EXPECT_EQ(c.both, 1);
  EXPECT_EQ(c.only_first, 1);
  EXPECT_EQ(c.only_second, 1);
  EXPECT_EQ(c.same_outcome, 1);
  EXPECT_EQ(c.p_value, McNemarExact(1, 1));
}

TEST(Differing, ArePairsThatOneOfThemWonAlone) {
  const std::vector<Record> a = {With(0, "won"), With(1, "won"), With(2, "lost"), With(3, "lost")};
  const std::vector<Record> b = {With(3, "gone"), With(2, "won"), With(0, "won"), With(1, "lost"),
                                 With(4, "won")};
  const std::vector<std::pair<std::size_t, std::size_t>> expected = {{2, 1}, {1, 3}};
  EXPECT_EQ(Differing(a, b, "won"), expected);
}

TEST(Compare, TellsWhichOfTheTwoWonAlone) {
  std::vector<Record> a, b;
  for (int i = 0; i < 8; ++i) {
    a.push_back(With(i, i < 7 ? "won" : "lost"));
    b.push_back(With(i, i < 2 || i == 7 ? "won" : "lost"));
  }
  const Comparison c = Compare(a, b, "won");
  EXPECT_EQ(c.both, 2);
  EXPECT_EQ(c.only_first, 5);
  EXPECT_EQ(c.only_second, 1);
  EXPECT_NEAR(c.p_value, 2.0 * (1.0 + 6.0) / 64.0, 1e-12);  // both tails of six throws of a coin
}

TEST(StageTimes, KeepTheOrderAndInterpolate) {
  std::vector<Record> records(3);
  records[0].result.seconds = {{"scan", 1.0}, {"plan", 4.0}};
  records[1].result.seconds = {{"scan", 3.0}};
  records[2].result.seconds = {{"scan", 2.0}};
  const auto times = StageTimes(records);
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].stage, "scan");
  EXPECT_DOUBLE_EQ(times[0].median_s, 2.0);
  EXPECT_DOUBLE_EQ(times[0].p95_s, 2.9);  // position 0.95 * 2 = 1.9 of 1, 2, 3
  EXPECT_DOUBLE_EQ(times[1].median_s, 4.0);
}

}  // namespace
}  // namespace rangegrasp::experiment
