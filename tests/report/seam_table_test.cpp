#include "report/seam_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "temp_folder.h"

namespace rangegrasp::report {
namespace {

using stitching::Evaluation;
using stitching::EvaluationResult;
using stitching::RunResult;
using stitching::SeamResult;
using testing::HasSubstr;
using testing_support::TempFolder;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

Evaluation Shipped(const std::string& name) {
  return stitching::ReadEvaluation(kSource / "experiments" / (name + ".yaml"));
}

nlohmann::json TablesOf(const Evaluation& evaluation, const EvaluationResult& result) {
  return nlohmann::json::parse(FormatSeam(evaluation, result, TableFormat::kJson));
}

// Two seams with an edge, ten profiles each, and one without.
EvaluationResult Rates() {
  EvaluationResult result;
  for (int seam = 0; seam < 3; ++seam) {
    SeamResult r;
    r.seam = seam;
    r.profiles = 10;
    r.shape = seam == 2 ? stitching::EdgeShape::kNone : stitching::EdgeShape::kStep;
    r.no_edge.fill(seam == 2 ? 9 : 0);
    if (seam < 2) {
      for (auto& tally : r.all) tally = {10, {2 + seam, 5, 8, 10}};
      r.centre = r.all;
    }
    result.seams.push_back(r);
  }
  return result;
}

TEST(SeamTable, RatesAreCountsOfAllSeamsBesideThePublished) {
  const auto json = TablesOf(Shipped("seam_base"), Rates());
  const std::string text = FormatSeam(Shipped("seam_base"), Rates(), TableFormat::kText);
  EXPECT_THAT(text, HasSubstr("20 profiles with an edge"));
  const auto& rows = json["tables"][0]["rows"];
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(stitching::kMethods)) << json.dump(1);
  // 5 of 20, 10 of 20, 16 of 20, 20 of 20 beside table 3.2.
  const auto combined = rows[3].dump();
  for (const char* cell :
       {"Combined Result", "25.0", "80.4", "50.0", "97.5", "80.0", "99.3", "100.0", "99.5"}) {
    EXPECT_THAT(combined, HasSubstr(cell));
  }
  // Told to have no edge: 9 of the 10 profiles that have none.
  EXPECT_THAT(json.dump(), HasSubstr("90.0"));
}

TEST(SeamTable, HazardsThatCameIntoViewAreFoundOrReached) {
  EvaluationResult result;
  for (int run = 0; run < 5; ++run) {
    RunResult r;
    r.run = run;
    r.hazard = "obstacle";
    r.end = run < 3 ? stitching::TrackEnd::kObstacle : stitching::TrackEnd::kMatEnd;
    if (run == 3) r.stopped_early = true;
    if (run == 4) {
      r.end = stitching::TrackEnd::kDone;
      r.reached_hazard = true;
    }
    result.runs.push_back(r);
  }
  const auto csv = FormatSeam(Shipped("seam_hazards"), result, TableFormat::kCsv);
  EXPECT_THAT(csv, HasSubstr("obstacle,Combined Result,5,1,4,3,1,75.00,0"));
}

TEST(SeamTable, TracksAreWeightedByTheirLength) {
  EvaluationResult result;
  for (const double length : {0.1, 0.3}) {
    RunResult r;
    r.settled_m = length;
    r.mean_error_m = length == 0.1 ? 0.4e-3 : 0.0;
    r.share_within_1mm = length == 0.1 ? 0.6 : 1.0;
    r.max_error_m = length * 1e-2;
    result.runs.push_back(r);
  }
  const auto csv = FormatSeam(Shipped("seam_track"), result, TableFormat::kCsv);
  EXPECT_THAT(csv, HasSubstr("Combined Result,2,2,0,0.100,0.000,3.000,90.00"));
}

TEST(SeamTable, EveryFormatHoldsEveryMethodAndTheStamp) {
  for (const auto format :
       {TableFormat::kText, TableFormat::kMarkdown, TableFormat::kCsv, TableFormat::kJson}) {
    const std::string out = FormatSeam(Shipped("seam_three_lines"), Rates(), format);
    for (int m = 0; m < stitching::kMethods; ++m) {
      EXPECT_THAT(out, HasSubstr(stitching::MethodName(m)));
    }
    // CSV is for programs: tables only.
    EXPECT_EQ(out.find("sensor_hash") == std::string::npos, format == TableFormat::kCsv);
  }
}

TEST(SeamTable, NamesABrokenPublishedTable) {
  const TempFolder folder;
  Evaluation evaluation = Shipped("seam_base");
  evaluation.reference = folder.Write("t.csv", "method,a\nModel-Fitting,many\n");
  try {
    FormatSeam(evaluation, {}, TableFormat::kText);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(evaluation.reference.string() + ":2: 'many'"));
  }
}

TEST(SeamRows, AreOneALineInOrder) {
  const std::string csv = SeamRowsCsv(Rates());
  EXPECT_GE(std::count(csv.begin(), csv.end(), '\n'), 4);
  EvaluationResult runs;
  runs.runs.resize(3);
  const std::string lines = SeamRowsCsv(runs);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 4);
}

}  // namespace
}  // namespace rangegrasp::report
