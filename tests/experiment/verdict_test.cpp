#include "experiment/verdict.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rangegrasp::experiment {
namespace {

PublishedFigure RateOf(Share own, Share published, bool lower_is_better = false) {
  return {.row = "cup",
          .unit = "%",
          .lower_is_better = lower_is_better,
          .published = 100.0 * published.k / published.n,
          .own = own.n > 0 ? std::optional(100.0 * own.k / own.n) : std::nullopt,
          .evidence = TrialsEvidence{own, published}};
}

Verdict OnlyVerdict(const PublishedFigure& figure) { return Judge({figure}).rows.at(0).verdict; }

TEST(Judge, CountsAreBetterOrWorseOnlyWhereTheyDifferBeyondChance) {
  EXPECT_EQ(OnlyVerdict(RateOf({10, 10}, {2, 10})), Verdict::kBetter);
  EXPECT_EQ(OnlyVerdict(RateOf({2, 10}, {10, 10})), Verdict::kWorse);
  EXPECT_EQ(OnlyVerdict(RateOf({2, 10}, {10, 10}, /*lower_is_better=*/true)), Verdict::kBetter);
  EXPECT_EQ(OnlyVerdict(RateOf({1, 1}, {2, 10})), Verdict::kSame);
  EXPECT_EQ(OnlyVerdict(RateOf({0, 0}, {2, 10})), Verdict::kNoFigure);
}

TEST(Judge, TheThresholdIsSharedByTheTestsOfATable) {
  // 14 of 20 beside 5 of 20: p is 0.0104 (R: twice the tail of phyper), below 0.05 and above 0.05
  // / 5.
  std::vector<PublishedFigure> figures = {RateOf({14, 20}, {5, 20})};
  EXPECT_NEAR(Judge(figures).rows[0].p.value(), 0.0104, 5e-5);
  EXPECT_EQ(Judge(figures).rows[0].verdict, Verdict::kBetter);
  figures.insert(figures.end(), 4, RateOf({5, 10}, {5, 10}));
  figures.push_back(RateOf({0, 0}, {5, 10}));  // no test
  const JudgedTable table = Judge(figures);
  EXPECT_DOUBLE_EQ(table.threshold, 0.05 / 5);
  EXPECT_EQ(table.rows[0].verdict, Verdict::kSame);
}

TEST(Judge, ProfilesOfSeamsThatAgreeCountAsOneEach) {
  PublishedFigure figure{.row = "voting", .unit = "%", .published = 90.0, .own = 100.0};
  figure.evidence = ClustersEvidence{std::vector<Cluster>(10, {500, 500})};
  // z = 0.1 / sqrt(0.09 / 10): as 10 trials; 5,000 independent ones would be far beyond chance.
  const JudgedTable few = Judge({figure});
  EXPECT_NEAR(few.rows[0].p.value(), std::erfc(0.1 / std::sqrt(0.009) / std::sqrt(2.0)), 1e-12);
  EXPECT_EQ(few.rows[0].verdict, Verdict::kSame);
  figure.evidence = ClustersEvidence{std::vector<Cluster>(5000, {1, 1})};
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kBetter);
}

TEST(Judge, AMeanIsComparedByItsScatter) {
  PublishedFigure figure{
      .row = "RCF", .unit = "mm", .lower_is_better = true, .published = 0.4, .own = 0.2};
  figure.evidence = MeanEvidence{{0.2, 0.01, 50}};
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kBetter);
  figure.evidence = MeanEvidence{{0.2, 0.2, 3}};
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kSame);
  figure.evidence = MeanEvidence{{0.2, std::nullopt, 1}};
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kSame);
}

TEST(Judge, OfTimesOnlyMoreThanWhatComputersDifferByIsBetter) {
  PublishedFigure figure{
      .row = "plane fit", .unit = "s", .lower_is_better = true, .published = 1.0};
  figure.evidence = TimesEvidence{5};
  figure.own = 0.09;
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kBetter);
  figure.own = 0.11;
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kSame);
  figure.own = 1.1;
  EXPECT_EQ(OnlyVerdict(figure), Verdict::kWorse);
  EXPECT_EQ(Judge({figure}).threshold, 0.0);
}

TEST(Judge, EventsAreRatesOfRuns) {
  PublishedFigure figure{
      .row = "path planning", .lower_is_better = true, .published = 11.0, .own = 0.0};
  figure.evidence = EventsEvidence{{0, 50}, {11, 50}};
  const Judged row = Judge({figure}).rows[0];
  EXPECT_NEAR(row.p.value(), 2.0 / 2048.0, 1e-12);
  EXPECT_EQ(row.verdict, Verdict::kBetter);
}

}  // namespace
}  // namespace rangegrasp::experiment
