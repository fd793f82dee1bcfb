#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "error_of.h"
#include "seam/task/seam_score.h"
#include "seam/task/small_experiment.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

using experiment::Record;
using experiment::Report;
using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::Shipped;
using testing_support::TempFolder;
using Cells = std::vector<std::string>;

const std::string kVotingTitle = "Voting as published";

Record RecordOf(const SeamParams& params, const std::string& data) {
  Record record;
  record.which.params = ParamsOf(params);
  record.result = {"measured", "score", "", data, {}};
  return record;
}

Record Crashed(const SeamParams& params) {
  Record record = RecordOf(params, "{}");
  record.result.outcome = experiment::kCrashed;
  return record;
}

// A run with voting and, unless it names another one, no hazard.
Record RunRecord(RunResult run) {
  run.params.method = DecisionMethod::kVoting;
  return RecordOf(run.params, ToJson(run));
}

// Two seams with an edge, ten profiles each, and one without.
std::vector<Record> Rates() {
  std::vector<Record> records;
  for (int seam = 0; seam < 3; ++seam) {
    SeamResult r;
    r.params = {.number = seam, .shape = seam == 2 ? EdgeShape::kNone : EdgeShape::kStep};
    r.profiles = 10;
    for (std::size_t m = kAlone; m < kMethods; ++m) r.no_edge[m] = seam == 2 ? 9 : 0;
    if (seam < 2) {
      for (auto& tally : r.all) tally = {10, {2 + seam, 5, 8, 10}};
      r.center = r.all;
    }
    records.push_back(RecordOf(r.params, ToJson(r)));
  }
  return records;
}

Report ReportOn(const SeamExperiment& experiment, const std::vector<Record>& records) {
  experiment::Stamp stamp;
  AddTo(stamp, experiment);
  return ReportOf(stamp, records);
}

TEST(SeamTables, FiguresAreThoseOfTheTablesWithTheSeamsAsClusters) {
  auto records = Rates();
  records[0].result.seconds = {{"Model-Fitting", 0.004}};
  records[1].result.seconds = {{"Model-Fitting", 0.002}};
  const auto figures = ReportOn(Shipped("seam_base"), records).published;
  ASSERT_EQ(figures.size(), 16u + 5u);  // four methods at four tolerances; table 3.1
  EXPECT_EQ(figures[0].row, "Model-Fitting, +-3 px");
  EXPECT_EQ(figures[0].published, 85.7);
  EXPECT_EQ(figures[0].own, 25.0);
  const auto& seams = std::get<experiment::ClustersEvidence>(figures[0].evidence).own;
  ASSERT_EQ(seams.size(), 3u);
  EXPECT_EQ(seams[1].k, 3);
  EXPECT_EQ(seams[1].n, 10);
  EXPECT_EQ(seams[2].n, 0);  // has no edge
  EXPECT_EQ(figures[17].row, "Model-Fitting, average");
  EXPECT_EQ(figures[17].key, "runtimes");
  EXPECT_DOUBLE_EQ(figures[17].own.value(), 0.3);  // [ms]: 6 ms for 20 profiles
  EXPECT_DOUBLE_EQ(figures[17].published, 0.132);
  EXPECT_FALSE(figures[16].own);
}

TEST(SeamTables, FiguresOfTable35AreOfTheMethodsThatItNames) {
  const auto figures = ReportOn(Shipped("seam_three_lines"), Rates()).published;
  ASSERT_EQ(figures.size(), 16u + 4u);
  EXPECT_EQ(figures[18].row, "edge in the centre of the scan line");
  EXPECT_EQ(figures[18].key, "improvements");
  EXPECT_EQ(figures[18].own, 100.0);  // +-18 px are 1 mm for this sensor
  EXPECT_FALSE(figures[19].own);      // no edge lay at the boundary
}

TEST(SeamTables, RatesAreCountsOfAllSeamsBesideThePublished) {
  const Report report = ReportOn(Shipped("seam_base"), Rates());
  EXPECT_THAT(report.sections[0].title, HasSubstr("20 profiles with an edge, from 3 seams"));
  const auto& rows = report.sections[0].grid.rows;
  ASSERT_EQ(rows.size(), kMethods);
  // 5, 10, 16 and 20 of 20, each next to the value of table 3.2.
  EXPECT_EQ(rows[4], (Cells{"Voting as published", "25.00", "80.4", "50.00", "97.5", "80.00",
                            "99.3", "100.00", "99.5"}));
  EXPECT_EQ(rows[3][2], "-");  // our own method has no published values
  for (std::size_t m = 5; m < kMethods; ++m) EXPECT_EQ(rows[m][2], "-") << rows[m][0];
  // 1 mm is 12 px for the base sensor; no edge was at the boundary.
  EXPECT_EQ(report.sections[1].grid.rows[4], (Cells{"Voting as published", "80.00", "80.00", "-"}));
  // Of the 10 profiles without an edge, 9 were reported to have none.
  const auto& none = report.sections[2].grid.rows.back();
  EXPECT_EQ(none.front(), "none");
  EXPECT_EQ(none.back(), "90.00");
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_THAT(report.notes[0], HasSubstr("noise was fitted to the published rates"));
}

TEST(SeamTables, ImprovementsStandBelowThePlaces) {
  const auto rows = ReportOn(Shipped("seam_three_lines"), Rates()).sections[1].grid.rows;
  ASSERT_EQ(rows.size(), kMethods + 4);
  EXPECT_EQ(rows.back(),
            (Cells{"published: three-lines with sum of weights and historic edge positions",
                   "86.40", "", ""}));
}

// If either all or none of a seam's profiles are found, each seam is one coin toss. The standard
// error is then that of a binomial rate over seams, sqrt(p (1 - p) / (n - 1)), for any number of
// profiles per seam.
TEST(SeamTables, TheStandardErrorIsOverSeams) {
  for (const int profiles : {10, 1000}) {
    std::vector<Record> records;
    constexpr int kSeams = 50;
    for (int seam = 0; seam < kSeams; ++seam) {
      SeamResult r;
      r.profiles = profiles;
      for (auto& tally : r.all) tally.profiles = profiles;
      if (seam % 5 != 0) {
        for (auto& tally : r.all) tally.within.fill(profiles);
      }
      records.push_back(RecordOf({.number = seam}, ToJson(r)));
    }
    const auto row = ReportOn(Shipped("seam_base"), records).sections.back().grid.rows[0];
    EXPECT_EQ(row, (Cells{"Model-Fitting", "80.00",
                          fmt::format("{:.2f}", 100.0 * std::sqrt(0.8 * 0.2 / (kSeams - 1))),
                          fmt::format("{}", kSeams * profiles), "50"}));
  }
}

TEST(SeamTables, HazardsThatCameIntoViewAreFoundOrReached) {
  std::vector<Record> records;
  for (int run = 0; run < 5; ++run) {
    RunResult r;
    r.params = {.number = run, .hazard = Hazard::kObstacle};
    r.end = run < 3 ? TrackEnd::kObstacle : TrackEnd::kMatEnd;
    if (run == 3) r.stopped_early = true;
    if (run == 4) {
      r.end = TrackEnd::kDone;
      r.reached_hazard = true;
    }
    records.push_back(RunRecord(r));
  }
  const auto rows = ReportOn(Shipped("seam_hazards"), records).sections[0].grid.rows;
  ASSERT_EQ(rows.size(), 2U);  // for the one method that steered
  EXPECT_EQ(rows[1], (Cells{"obstacle", kVotingTitle, "5", "1", "4", "3", "1", "75.00"}));
}

// Two tracks of 100 and 300 mm; 300 mm were required. The first is within 1 mm for 60 % of 100 mm.
TEST(SeamTables, TracksAreWeightedByTheirLength) {
  std::vector<Record> records;
  for (const double length : {0.1, 0.3}) {
    RunResult r;
    r.settled_m = length;
    r.stopped_early = length == 0.1;
    r.mean_error_m = length == 0.1 ? 0.4e-3 : 0.0;
    r.share_within_1mm = length == 0.1 ? 0.6 : 1.0;
    r.max_error_m = length * 1e-2;
    records.push_back(RunRecord(r));
  }
  const auto rows = ReportOn(Shipped("seam_track"), records).sections[0].grid.rows;
  // 60 mm + 300 mm of 600 mm. The shares 0.2 and 1 deviate by 0.4 from 0.6.
  EXPECT_EQ(rows[0], (Cells{kVotingTitle, "2", "2", "1", "0.100", "3.000", "60.00", "40.00"}));
  EXPECT_EQ(rows.size(), 1U);
}

TEST(SeamTables, ACrashedCaseCountsAsFailed) {
  auto seams = Rates();
  SeamParams params;
  params.number = 3;
  seams.push_back(Crashed(params));
  SeamExperiment base = Shipped("seam_base");
  base.record.profiles = 10;
  const Report rates = ReportOn(base, seams);
  EXPECT_THAT(rates.sections[0].title, HasSubstr("30 profiles with an edge, from 4 seams"));
  EXPECT_EQ(rates.sections[0].grid.rows[0][1], "16.67");  // 5 of 30
  ASSERT_EQ(rates.notes.size(), 2U);
  EXPECT_THAT(rates.notes[1], HasSubstr("1 of 4 cases crashed"));

  RunResult done;
  done.settled_m = 0.3;
  done.share_within_1mm = 1.0;
  params.method = DecisionMethod::kVoting;
  const Report tracks = ReportOn(Shipped("seam_track"), {RunRecord(done), Crashed(params)});
  const Cells& row = tracks.sections[0].grid.rows[0];
  EXPECT_EQ((Cells{row[1], row[2], row[3], row[6]}), (Cells{"2", "1", "1", "50.00"}));

  params.hazard = Hazard::kMatEnd;
  const Report hazards = ReportOn(Shipped("seam_hazards"), {Crashed(params)});
  EXPECT_EQ(hazards.sections[0].grid.rows[0],
            (Cells{"mat_end", kVotingTitle, "1", "0", "1", "0", "1", "0.00"}));
}

TEST(SeamTables, EveryTableOfRatesHoldsEveryMethod) {
  const Report report = ReportOn(Shipped("seam_three_lines"), Rates());
  ASSERT_EQ(report.sections.size(), 4U);
  for (const experiment::Section& section : report.sections) {
    const std::string text = experiment::CsvOf(section.grid);
    for (std::size_t m = 0; m < kMethods; ++m) EXPECT_THAT(text, HasSubstr(MethodTitle(m)));
  }
}

TEST(SeamTables, NamesABrokenPublishedTable) {
  const TempFolder folder;
  SeamExperiment experiment = Shipped("seam_base");
  experiment.reference = folder.Write("t.csv", "method,a\nModel-Fitting,many\n");
  EXPECT_THAT(
      ErrorOf([&] { ReportOn(experiment, {}); }),
      testing::AllOf(HasSubstr(experiment.reference.string() + ":2:"), HasSubstr("'many'")));
}

TEST(SeamTables, AnEmptyPublishedTableIsRefused) {
  const TempFolder folder;
  SeamExperiment experiment = Shipped("seam_base");
  for (const char* text : {"", "method,a\n"}) {
    experiment.reference = folder.Write("t.csv", text);
    EXPECT_THAT(ErrorOf([&] { ReportOn(experiment, {}); }),
                HasSubstr(experiment.reference.string() + ": "));
  }
}

TEST(SeamTables, ANumberOfTheStampThatIsNoneIsNamed) {
  experiment::Stamp stamp;
  AddTo(stamp, Shipped("seam_base"));
  stamp.data["wanted_m"] = "wide";
  EXPECT_THAT(ErrorOf([&] { ReportOf(stamp, {}); }),
              HasSubstr("stamp 'wanted_m': 'wide' must be a number"));
}

TEST(SeamTables, AStampOfAnotherKindIsRefused) { EXPECT_THROW(ReportOf({}, {}), base::InputError); }

}  // namespace
}  // namespace rangegrasp::seam
