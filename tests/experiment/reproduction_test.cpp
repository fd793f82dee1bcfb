#include "experiment/reproduction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "experiment/report.h"

namespace rangegrasp::experiment {
namespace {

PublishedFigure RateOf(Count own, Count published, bool lower_is_better = false) {
  return {.row = "cup",
          .unit = "%",
          .lower_is_better = lower_is_better,
          .published = 100.0 * published.k / published.n,
          .own = own.n > 0 ? std::optional(100.0 * own.k / own.n) : std::nullopt,
          .evidence = TrialsEvidence{own, published}};
}

Verdict OnlyVerdict(const PublishedFigure& figure, bool is_whole = false) {
  return Judge({figure}, is_whole).rows.at(0).verdict.value();
}

TEST(Judge, CountsAreBetterOrWorseOnlyWhereTheyDifferBeyondChance) {
  EXPECT_EQ(OnlyVerdict(RateOf({10, 10}, {2, 10})), Verdict::kBetter);
  EXPECT_EQ(OnlyVerdict(RateOf({2, 10}, {10, 10})), Verdict::kWorse);
  EXPECT_EQ(OnlyVerdict(RateOf({2, 10}, {10, 10}, /*lower_is_better=*/true)), Verdict::kBetter);
  EXPECT_EQ(OnlyVerdict(RateOf({1, 1}, {2, 10})), Verdict::kSame);
}

// Rows of 900 of 1000 and 0 of 10: their mean is 45 %, below the published 60 %; their counts are
// above those published.
TEST(Judge, CountsThatDifferInTheOtherDirectionThanTheFiguresAreNoVerdict) {
  PublishedFigure overall = RateOf({900, 1010}, {12, 20});
  EXPECT_EQ(OnlyVerdict(overall), Verdict::kBetter);
  overall.own = 45.0;
  EXPECT_LT(Judge({overall}, false).rows[0].p.value(), 0.05);
  EXPECT_EQ(OnlyVerdict(overall), Verdict::kSame);
  overall.lower_is_better = true;
  EXPECT_EQ(OnlyVerdict(overall), Verdict::kSame);
}

TEST(Judge, WhatAWholeRunDoesNotCountIsWorseAndNotMerelyMissing) {
  for (const bool lower_is_better : {false, true}) {
    const PublishedFigure none = RateOf({0, 0}, {2, 10}, lower_is_better);
    EXPECT_EQ(OnlyVerdict(none, /*is_whole=*/false), Verdict::kNoFigure);
    EXPECT_EQ(OnlyVerdict(none, /*is_whole=*/true), Verdict::kWorse);
  }
  const JudgedTable table = Judge({RateOf({0, 0}, {2, 10})}, /*is_whole=*/true);
  EXPECT_FALSE(table.rows[0].p);
  EXPECT_EQ(table.threshold, 0.0) << "it is no test";
}

TEST(Judge, TheThresholdIsSharedByTheTestsOfATable) {
  // For 14 of 20 against 5 of 20, p is 0.0104 (R: twice the tail of phyper), below 0.05 and above
  // 0.05 / 5.
  std::vector<PublishedFigure> figures = {RateOf({14, 20}, {5, 20})};
  EXPECT_NEAR(Judge(figures, false).rows[0].p.value(), 0.0104, 5e-5);
  EXPECT_EQ(Judge(figures, false).rows[0].verdict, Verdict::kBetter);
  figures.insert(figures.end(), 4, RateOf({5, 10}, {5, 10}));
  figures.push_back(RateOf({0, 0}, {5, 10}));  // no test
  const JudgedTable table = Judge(figures, false);
  EXPECT_DOUBLE_EQ(table.threshold, 0.05 / 5);
  EXPECT_EQ(table.rows[0].verdict, Verdict::kSame);
}

TEST(Judge, ProfilesOfSeamsThatAgreeCountAsOneEach) {
  PublishedFigure figure{.row = "voting", .unit = "%", .published = 90.0, .own = 100.0};
  figure.evidence = ClustersEvidence{std::vector<Count>(10, {500, 500})};
  // z = 0.1 / sqrt(0.09 / 10), as for 10 trials; 5,000 independent ones would be far beyond chance.
  const JudgedTable few = Judge({figure}, false);
  EXPECT_NEAR(few.rows[0].p.value(), std::erfc(0.1 / std::sqrt(0.009) / std::sqrt(2.0)), 1e-12);
  EXPECT_EQ(few.rows[0].verdict, Verdict::kSame);
  figure.evidence = ClustersEvidence{std::vector<Count>(5000, {1, 1})};
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
  EXPECT_EQ(Judge({figure}, false).threshold, 0.0);
}

TEST(Judge, EventsAreRatesOfRuns) {
  PublishedFigure figure{
      .row = "path planning", .lower_is_better = true, .published = 11.0, .own = 0.0};
  figure.evidence = EventsEvidence{{0, 50}, {11, 50}};
  const Judged row = Judge({figure}, false).rows[0];
  EXPECT_NEAR(row.p.value(), 2.0 / 2048.0, 1e-12);
  EXPECT_EQ(row.verdict, Verdict::kBetter);
}

using testing::HasSubstr;
using testing::Not;

// A complete table with one better and one worse figure, one that was begun, one without results,
// and one that cannot be run.
Reproduction Some(bool is_short) {
  Reproduction all{is_short, {}};
  all.tables.push_back({.number = "5.2", .title = "alone", .experiment = "single"});
  all.tables[0].done = all.tables[0].cases = 20;
  std::vector<PublishedFigure> figures = {RateOf({10, 10}, {0, 10}), RateOf({0, 10}, {10, 10})};
  figures[1].row = "box";
  all.tables[0].judged = is_short ? NotJudged(figures) : Judge(figures, true);
  all.tables.push_back({.number = "5.3", .title = "touching", .experiment = "touching"});
  all.tables[1].done = 3;
  all.tables[1].cases = 20;
  all.tables.push_back({.number = "5.4", .title = "box", .experiment = "box"});
  all.tables[2].cases = 20;
  all.tables.push_back({.number = "6.1", .title = "parts", .experiment = "parts"});
  all.tables[3].left_out = "there is no folder psb";
  return all;
}

std::string TextOf(const Reproduction& all) {
  return Format(PageOf(all), {}, TableFormat::kMarkdown);
}

TEST(Page, TellsOfEachTableHowFarItIsAndWhyItIsNotThere) {
  const std::string text = TextOf(Some(false));
  EXPECT_THAT(text, HasSubstr("| 5.2 | alone | single | done | 20 | 2 | 1 | 0 | 1 | 0 |"));
  EXPECT_THAT(text, HasSubstr("| 5.3 | touching | touching | 3 of 20 cases |"));
  EXPECT_THAT(text, HasSubstr("| 5.4 | box | box | not run yet |"));
  EXPECT_THAT(text, HasSubstr("| 6.1 | parts | parts | left out |"));
  EXPECT_THAT(text, HasSubstr("6.1 is left out: there is no folder psb"));
  EXPECT_THAT(text, HasSubstr("| cup | 0.0 | 100.0 | % | higher | 10 of 10, published 0 of 10 |"));
  EXPECT_THAT(text, HasSubstr("Fisher's exact test"));
  EXPECT_THAT(text, Not(HasSubstr("short run")));
}

// Its figures differ as much as possible, but still get no verdict.
TEST(Page, AShortRunHasNoVerdictsAndSaysWhatItShows) {
  const std::string text = TextOf(Some(true));
  EXPECT_THAT(text, HasSubstr("a short run shows only that everything runs"));
  EXPECT_THAT(text, HasSubstr("| 5.2 | alone | single | done | 20 | 2 |"));
  EXPECT_THAT(text, HasSubstr("| cup | 0.0 | 100.0 | % | higher |\n"));
  for (const char* word : {"better |", "worse", "same", "verdict |", "Fisher", "0.05"}) {
    EXPECT_THAT(text, Not(HasSubstr(word)));
  }
}

}  // namespace

}  // namespace rangegrasp::experiment
