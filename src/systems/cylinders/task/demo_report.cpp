#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/statistics.h"
#include "cylinders/task/cylinders_task.h"
#include "cylinders/task/demo_detector.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {
namespace {

using experiment::Column;
using experiment::Count;
using experiment::Grid;
using experiment::IntervalText;
using experiment::PublishedFigure;
using nlohmann::ordered_json;

/// A row of table 4.1, or a problem that it does not count, with the published figures of 50 runs.
constexpr int kPublishedRuns = 50;
struct ProblemRow {
  const char* name;
  std::optional<int> published_events;
  std::optional<int> published_influence;  ///< those with influence
  int first_events = 0;                    ///< with one try, as published
  int first_influence = 0;                 ///< with one try
  int events = 0;                          ///< in all tries
  int influence = 0;
};
enum class Problem { kPlanning, kHand, kRecognition, kHandOver, kOther };  ///< rows in order

/// The kind of problem behind a failed outcome; nullopt if the run did not fail.
std::optional<Problem> FailureOf(const std::string& outcome) {
  static const std::map<std::string, Problem> problems = {
      {"no_grasp", Problem::kPlanning},        {"no_path", Problem::kPlanning},
      {"not_lifted", Problem::kHand},          {"dropped", Problem::kHand},
      {"misplaced", Problem::kHand},           {"not_segmented", Problem::kRecognition},
      {"wrong_target", Problem::kRecognition}, {"felt_early", Problem::kHandOver},
      {"not_felt", Problem::kHandOver},        {"not_taken", Problem::kHandOver}};
  if (outcome == trial::kHandedOver || outcome == "delivered") return std::nullopt;
  const auto found = problems.find(outcome);
  return found == problems.end() ? Problem::kOther : found->second;
}

struct Tally {
  int runs = 0, first_good = 0, good = 0, carried = 0, felt = 0;
  std::vector<ProblemRow> problems = {{"path planning", 11, 11},
                                      {"hand prosthesis", 4, 0},
                                      {"object recognition", 2, 2},
                                      {"handing over", {}, {}},
                                      {"simulation", {}, {}}};

  ProblemRow& RowOf(Problem problem) { return problems[static_cast<std::size_t>(problem)]; }
  /// The problems and their sum, including those that the dissertation does not count.
  std::vector<ProblemRow> RowsWithSum() const {
    std::vector<ProblemRow> rows = problems;
    ProblemRow sum{"sum", 17, 13};
    for (const ProblemRow& row : problems) {
      sum.first_events += row.first_events;
      sum.first_influence += row.first_influence;
      sum.events += row.events;
      sum.influence += row.influence;
    }
    rows.push_back(sum);
    return rows;
  }
};

/// A situation of the wanted cylinder; the runs in it are counted.
struct Place {
  const char* name;
  bool (*is_one)(const ordered_json& data);
};
/// The dissertation requires that nothing stands closer than this ("a minimum distance of 20mm,
/// equal to the diameter of the thumb", section 4.1).
constexpr double kThumb_m = 0.020;
bool IsClear(const ordered_json& d) { return d.value("clearance_m", 0.0) >= kThumb_m; }
constexpr std::array<Place, 7> kPlaces = {{
    {"standing", [](const ordered_json& d) { return d.value("stands", false); }},
    {"lying",
     [](const ordered_json& d) { return d.contains("stands") && !d.value("stands", false); }},
    {"nothing within 20 mm", IsClear},
    {"something within 20 mm",
     [](const ordered_json& d) { return d.value("clearance_m", kThumb_m) < kThumb_m; }},
    // The conditions of chapter 4, which also requires that the scanner sees the top.
    {"standing, nothing within 20 mm",
     [](const ordered_json& d) { return d.value("stands", false) && IsClear(d); }},
    {"touched by something", [](const ordered_json& d) { return d.value("touching", 0) > 0; }},
    {"all", [](const ordered_json&) { return true; }},
}};

/// A record with its parsed data.
struct DemoRun {
  const experiment::Record& record;
  ordered_json data;  ///< an object
  /// Outcomes of its tries; the run's own outcome if the record has no tries.
  std::vector<std::string> tries;

  explicit DemoRun(const experiment::Record& r)
      : record(r), data(ordered_json::parse(r.result.data, nullptr, false)) {
    if (!data.is_object()) data = ordered_json::object();
    for (const auto& one : data.value("tries", ordered_json::array())) {
      tries.push_back(one.value("outcome", ""));
    }
    if (tries.empty()) tries.push_back(record.result.outcome);
  }
  std::optional<Problem> Failure() const { return FailureOf(record.result.outcome); }
  /// How the run would have ended after one try.
  std::optional<Problem> FirstFailure() const { return FailureOf(tries.front()); }
  /// True if the first try pushed other objects; older records have this for all tries together.
  bool FirstMovedOthers() const {
    const auto all = data.value("tries", ordered_json::array());
    const int moved = data.value("others_moved", 0);
    return (all.empty() ? moved : all.front().value("others_moved", moved)) > 0;
  }
};

void Add(const DemoRun& run, Tally& tally) {
  const ordered_json& data = run.data;
  ++tally.runs;
  bool hand = false;
  for (const std::string& outcome : run.tries) {
    const auto failure = FailureOf(outcome);
    if (!failure) continue;
    ++tally.RowOf(*failure).events;
    hand = hand || *failure == Problem::kHand;
  }
  const auto first = run.FirstFailure();
  if (first) ++tally.RowOf(*first).first_events;
  ++(first ? tally.RowOf(*first).first_influence : tally.first_good);
  if (run.FirstMovedOthers() && first != Problem::kHand) {
    ++tally.RowOf(Problem::kHand).first_events;
  }
  const auto influence = run.Failure();
  ++(influence ? tally.RowOf(*influence).influence : tally.good);
  // Counts runs that pushed other objects without further effect. Section 4.4 counts fingers that
  // "shift the grasp object" itself, which the records do not have.
  if (data.value("others_moved", 0) > 0 && !hand) ++tally.RowOf(Problem::kHand).events;
  const auto log = data.value("log", ordered_json::object());
  if (!log.contains("hand_over") || !log.value("held_after_carry", false)) return;
  ++tally.carried;
  tally.felt += log["hand_over"].value("felt", false) && !log["hand_over"].value("early", false);
}

std::string Percent(int k, int n) { return experiment::PercentText(k, n, 1); }

Grid ProblemGrid(const Tally& tally) {
  using R = ProblemRow;
  const std::vector<Column<R>> columns = {
      {"problem", "", &R::name, experiment::kLeft},
      {"one try: events", "", &R::first_events},
      {"one try: runs failed", "", &R::first_influence},
      {"one try: %", "", [&](const R& row) { return Percent(row.first_influence, tally.runs); }},
      {"one try: 95 %", "",
       [&](const R& row) { return IntervalText(row.first_influence, tally.runs); }},
      {"all tries: events", "", &R::events},
      {"all tries: runs failed", "", &R::influence},
      {"%", "", [&](const R& row) { return Percent(row.influence, tally.runs); }},
      {"95 %", "", [&](const R& row) { return IntervalText(row.influence, tally.runs); }},
      {"published", "", &R::published_events},
      {"published influence %", "", [](const R& row) {
         const auto& published = row.published_influence;
         return published ? std::optional(100 * *published / kPublishedRuns) : std::nullopt;
       }}};
  return GridOf(columns, tally.RowsWithSum());
}

std::vector<PublishedFigure> FiguresOf(const Tally& tally) {
  std::vector<PublishedFigure> figures;
  const auto add = [&](const std::string& row, const Count& own, const Count& published,
                       const experiment::Evidence& evidence) {
    figures.push_back({.row = row,
                       .unit = "in 50 runs",
                       .lower_is_better = true,
                       .published = static_cast<double>(published.k),
                       .evidence = evidence});
    if (own.n > 0) figures.back().own = 1.0 * kPublishedRuns * own.k / own.n;
  };
  for (const ProblemRow& row : tally.RowsWithSum()) {
    if (!row.published_events) continue;
    // The published demo had only one try.
    const Count events{row.first_events, tally.runs};
    const Count influence{row.first_influence, tally.runs};
    const Count published_events{*row.published_events, kPublishedRuns};
    const Count published_influence{*row.published_influence, kPublishedRuns};
    add(fmt::format("{}, events", row.name), events, published_events,
        experiment::EventsEvidence{events, published_events});
    add(fmt::format("{}, runs that failed because of it", row.name), influence, published_influence,
        experiment::TrialsEvidence{influence, published_influence});
  }
  return figures;
}

/// Table 4.2: seconds for each step of DetectCylinders; a row without a step is the sum of all.
struct StepRow {
  const char* name;
  const char* step;
  double published_s;
};
constexpr std::array<StepRow, 7> kSteps = {
    {{"plane fit", "plane", 1.406},
     {"geometrical filter", "filter", 1.938},
     {"normal vector calculation", "normals", 0.312},
     {"curvature analysis", "curvature", 0.469},
     {"curvature points segmentation", "segmentation", 0.485},
     {"cylinder detection", "cylinders", 0.015},
     {"sum", "", 4.625}}};

// Medians of the runs with a single try; for several tries only the sum is stored.
std::vector<PublishedFigure> TimesOf(const std::vector<DemoRun>& runs) {
  std::vector<PublishedFigure> figures;
  for (const auto& [name, step, published_s] : kSteps) {
    const std::string stage_of_step = kCylinderStep + std::string(step);
    std::vector<double> all;
    for (const DemoRun& run : runs) {
      if (run.tries.size() != 1) continue;
      double sum = 0.0;
      for (const auto& [stage, seconds] : run.record.result.seconds) {
        if (*step == '\0' ? stage.starts_with(stage_of_step) : stage == stage_of_step)
          sum += seconds;
      }
      if (sum > 0.0) all.push_back(sum);
    }
    figures.push_back({.row = name,
                       .unit = "s",
                       .digits = 4,
                       .lower_is_better = true,
                       .published = published_s,
                       .evidence = experiment::TimesEvidence{static_cast<int>(all.size())},
                       .key = "runtimes"});
    if (!all.empty()) figures.back().own = base::MedianOf(all);
  }
  return figures;
}

/// Whether the wanted cylinder was recognised, whatever failed later.
bool Recognised(const std::optional<Problem>& failure) {
  return failure != Problem::kRecognition && failure != Problem::kOther;
}

/// Stages that the runs reached, by the situation of the wanted cylinder.
Grid PlaceGrid(const std::vector<DemoRun>& runs) {
  struct Row {
    const char* name;
    int runs = 0, first_found = 0, first_good = 0, recognised = 0, carried = 0, good = 0;
  };
  const std::vector<Column<Row>> columns = {
      {"wanted cylinder", "", &Row::name, experiment::kLeft},
      {"runs", "", &Row::runs},
      {"one try: recognised", "", &Row::first_found},
      {"one try: handed over or placed", "", &Row::first_good},
      {"one try: %", "", [](const Row& row) { return Percent(row.first_good, row.runs); }},
      {"one try: 95 %", "", [](const Row& row) { return IntervalText(row.first_good, row.runs); }},
      {"all tries: recognised", "", &Row::recognised},
      {"all tries: carried", "", &Row::carried},
      {"all tries: handed over or placed", "", &Row::good},
      {"%", "", [](const Row& row) { return Percent(row.good, row.runs); }},
      {"95 %", "", [](const Row& row) { return IntervalText(row.good, row.runs); }}};
  std::vector<Row> rows;
  for (const Place& place : kPlaces) {
    Row& row = rows.emplace_back(Row{place.name});
    for (const DemoRun& run : runs) {
      if (!place.is_one(run.data)) continue;
      const auto failure = run.Failure();
      const auto first = run.FirstFailure();
      const auto log = run.data.value("log", ordered_json::object());
      ++row.runs;
      row.first_found += Recognised(first);
      row.first_good += !first;
      row.recognised += Recognised(failure);
      row.carried += log.value("held_after_carry", false);
      row.good += !failure;
    }
  }
  return GridOf(columns, rows);
}

}  // namespace

experiment::Report DemoReport(const experiment::Stamp&,
                              const std::vector<experiment::Record>& records) {
  const std::vector<DemoRun> runs(records.begin(), records.end());
  Tally tally;
  std::map<std::string, int> failures;
  for (const DemoRun& run : runs) {
    Add(run, tally);
    if (run.Failure()) ++failures[run.record.result.outcome];
  }
  const auto share = [](int k, int n) {
    return fmt::format("({} %, 95 %: {})", Percent(k, n), IntervalText(k, n));
  };
  experiment::Report report;
  report.csv = ProblemGrid(tally);
  report.sections = {{"", report.csv}, {"Progress of the runs", PlaceGrid(runs)}};
  report.notes = {
      fmt::format("published: 50 runs, one try each; with one try {} of {} runs were successful "
                  "{}, with all tries {} {}",
                  tally.first_good, tally.runs, share(tally.first_good, tally.runs), tally.good,
                  share(tally.good, tally.runs)),
      "failures: " + (failures.empty() ? "none" : experiment::CountsText(failures)),
      "hand prosthesis: the object was not held, or another one was pushed by more than 5 mm; the "
      "published events are other ones: fingers shifted the grasped object without effect",
      "influence: share of runs that failed because of the problem; in the other runs, another try "
      "solved it"};
  if (tally.carried > 0) {
    report.notes.push_back(
        fmt::format("the pull was detected in {} of {} runs that carried the object {}", tally.felt,
                    tally.carried, share(tally.felt, tally.carried)));
  }
  report.published = FiguresOf(tally);
  std::ranges::move(TimesOf(runs), std::back_inserter(report.published));
  return report;
}

}  // namespace rangegrasp::cylinders
