#include "seam/task/internal/run_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/csv.h"
#include "base/units.h"
#include "seam/task/seam_json.h"

namespace rangegrasp::seam_task::internal {
namespace {

using experiment::Fixed;
using experiment::Record;
using experiment::Section;
using stitching::TrackEnd;

// A run that was not finished: nothing followed, or a hazard that was not stopped for.
RunResult FailedRun(const SeamParams& params) {
  RunResult result;
  result.run = params.number;
  result.method = params.method.value();
  result.hazard = params.hazard;
  result.end = TrackEnd::kLost;
  result.reached_hazard = params.hazard != Hazard::kNone;
  result.stopped_early = params.hazard == Hazard::kNone;
  return result;
}

std::vector<RunResult> RunsOf(const std::vector<Record>& records) {
  std::vector<RunResult> runs;
  for (const Record& record : records) {
    const SeamParams params = ParamsFrom(record.which.params);
    runs.push_back(Failed(record) ? FailedRun(params) : RunResultFrom(params, record.result.data));
  }
  return runs;
}

// The ways to decide that steered any of the runs.
std::vector<seam::DecisionMethod> DecisionsOf(const std::vector<RunResult>& runs) {
  std::vector<seam::DecisionMethod> decisions;
  std::ranges::copy_if(kDecisions, std::back_inserter(decisions), [&](seam::DecisionMethod method) {
    return std::ranges::any_of(runs, [&](const RunResult& run) { return run.method == method; });
  });
  return decisions;
}

// Means over the length of all runs; the largest error of all.
Cells TracksRow(const Facts& facts, const std::vector<RunResult>& all,
                seam::DecisionMethod method) {
  int runs = 0;
  int done = 0;
  int early = 0;
  double mean = 0.0;
  double p95 = 0.0;
  double max = 0.0;
  double within = 0.0;
  double length = 0.0;
  std::vector<Part> parts;
  for (const RunResult& run : all) {
    if (run.method != method) continue;
    ++runs;
    done += run.end == TrackEnd::kDone ? 1 : 0;
    early += run.stopped_early ? 1 : 0;
    length += run.settled_m;
    mean += run.settled_m * run.mean_error_m;
    p95 += run.settled_m * run.p95_error_m;
    max = std::max(max, run.max_error_m);
    within += run.settled_m * run.share_within_1mm;
    parts.push_back({run.settled_m * run.share_within_1mm, facts.wanted_m});
  }
  // So that no length at all gives 0.
  const double n = std::max(1e-9, length);
  const double wanted = runs * facts.wanted_m;
  return {TitleOf(method),
          fmt::format("{}", runs),
          fmt::format("{}", done),
          fmt::format("{}", early),
          Fixed(mean / n * base::kMmPerM, 3),
          Fixed(p95 / n * base::kMmPerM, 3),
          Fixed(max * base::kMmPerM, 3),
          Fixed(within / n * 100.0, 2),
          runs > 0 ? Fixed(within / wanted * 100.0, 2) : "-",
          ErrorCell(parts)};
}

Section TracksSection(const Facts& facts, const std::vector<RunResult>& runs) {
  Section section{
      "Closed loop after the first 100 mm: error of the seam's distance to the edge",
      NumberGrid({"method", "runs", "to the end", "stopped early", "mean mm", "95 % mm", "max mm",
                  "within 1 mm, % of the length", "within 1 mm, % of the wanted length", "+-"})};
  for (const auto method : DecisionsOf(runs)) {
    section.grid.rows.push_back(TracksRow(facts, runs, method));
  }
  return section;
}

// A half circle without its corners, where the edge turns by 90 degrees.
Section CornersSection(const Facts& facts, const std::vector<RunResult>& runs) {
  Section section{
      fmt::format("Half circle: not within {:.0f} mm of its corners", kCorner_m * base::kMmPerM),
      NumberGrid({"method", "runs", "within 1 mm, % of the wanted length", "+-"})};
  for (const auto method : DecisionsOf(runs)) {
    std::vector<Part> parts;
    double good = 0.0;
    for (const RunResult& run : runs) {
      if (run.method != method) continue;
      good += run.good_beside_corners_m;
      parts.push_back({run.good_beside_corners_m, facts.beside_corners_m});
    }
    const double wanted = static_cast<double>(parts.size()) * facts.beside_corners_m;
    section.grid.rows.push_back({TitleOf(method), fmt::format("{}", parts.size()),
                                 parts.empty() ? "-" : Fixed(good / wanted * 100.0, 2),
                                 ErrorCell(parts)});
  }
  return section;
}

Section EarlySection(const std::vector<RunResult>& runs) {
  Section section{"Runs that stopped early",
                  NumberGrid({"run", "method", "hazard", "end", "at rest, mm along the track"})};
  for (const RunResult& run : runs) {
    if (!run.stopped_early) continue;
    section.grid.rows.push_back(
        {fmt::format("{}", run.run), TitleOf(run.method), std::string(base::Word(run.hazard)),
         std::string(base::Word(run.end)), Fixed(run.rest_m * base::kMmPerM, 1)});
  }
  return section;
}

Cells HazardsRow(const std::vector<RunResult>& all, Hazard hazard, seam::DecisionMethod method) {
  int runs = 0;
  int found = 0;
  int other = 0;
  int early = 0;
  for (const RunResult& run : all) {
    if (run.method != method || run.hazard != hazard) continue;
    ++runs;
    early += run.stopped_early ? 1 : 0;
    if (run.reached_hazard || run.end == TrackEnd::kDone || run.stopped_early) continue;
    ++found;
    other += base::Word(hazard) != base::Word(run.end) ? 1 : 0;
  }
  const int seen = runs - early;
  Cells row = {std::string(base::Word(hazard)), TitleOf(method)};
  for (const int count : {runs, early, seen, found, seen - found}) {
    row.push_back(fmt::format("{}", count));
  }
  row.push_back(ShareCell(found, seen));
  row.push_back(fmt::format("{}", other));
  return row;
}

Section HazardsSection(const std::vector<RunResult>& runs) {
  Section section{
      "Hazards: found, and the head at rest, before the needle is there",
      NumberGrid({"hazard", "method", "runs", "at rest before it was in view", "came into view",
                  "found in time", "reached", "in time %", "found as the other"})};
  for (const Hazard hazard : {Hazard::kMatEnd, Hazard::kObstacle}) {
    for (const auto method : DecisionsOf(runs)) {
      section.grid.rows.push_back(HazardsRow(runs, hazard, method));
    }
  }
  return section;
}

std::string RunRows(const std::vector<RunResult>& runs, const std::vector<Record>& records) {
  std::string text =
      "run,method,hazard,end,reached_hazard,stopped_early,settled_mm,mean_error_mm,p95_error_mm,"
      "max_error_mm,share_within_1mm\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunResult& run = runs[i];
    text += base::CsvLine(
        {fmt::format("{}", run.run), TitleOf(run.method), std::string(base::Word(run.hazard)),
         Failed(records[i]) ? records[i].result.outcome : std::string(base::Word(run.end)),
         run.reached_hazard ? "1" : "0", run.stopped_early ? "1" : "0",
         Fixed(run.settled_m * base::kMmPerM, 1), Fixed(run.mean_error_m * base::kMmPerM, 4),
         Fixed(run.p95_error_m * base::kMmPerM, 4), Fixed(run.max_error_m * base::kMmPerM, 4),
         Fixed(run.share_within_1mm, 5)});
  }
  return text;
}

}  // namespace

experiment::Report RunsReport(const Facts& facts, const std::vector<Record>& records) {
  const auto runs = RunsOf(records);
  experiment::Report report;
  report.sections = {facts.kind == SeamKind::kTracks ? TracksSection(facts, runs)
                                                     : HazardsSection(runs)};
  if (facts.beside_corners_m > 0.0) report.sections.push_back(CornersSection(facts, runs));
  if (std::ranges::any_of(runs, &RunResult::stopped_early)) {
    report.sections.push_back(EarlySection(runs));
  }
  report.files.emplace_back("rows.csv", RunRows(runs, records));
  return report;
}

}  // namespace rangegrasp::seam_task::internal
