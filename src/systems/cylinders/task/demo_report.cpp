#include "cylinders/task/demo_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/statistics.h"
#include "base/words.h"
#include "experiment/statistics.h"
#include "trial/table.h"

namespace rangegrasp::cylinders {
namespace {

using experiment::Grid;
using experiment::IntervalText;
using nlohmann::ordered_json;

/// The kinds of table 4.1, and what it does not count.
enum class Problem { kPlanning, kHand, kRecognition, kHandOver, kOther };
constexpr int kPublishedRuns = 50;
struct ProblemRow {
  const char* name;
  std::optional<int> events;     // published, in 50 runs
  std::optional<int> influence;  // those with influence
};
constexpr std::array<ProblemRow, 5> kProblemRows = {{
    {"path planning", 11, 11},
    {"hand prosthesis", 4, 0},
    {"object recognition", 2, 2},
    {"handing over", {}, {}},
    {"simulation", {}, {}},
}};
constexpr ProblemRow kSumRow = {"sum", 17, 13};

std::string CountCell(const std::optional<int>& count) {
  return count ? fmt::format("{}", *count) : "-";
}
// In per cent of the runs.
std::string PercentCell(const std::optional<int>& count) {
  return count ? fmt::format("{}", 100 * *count / kPublishedRuns) : "-";
}

bool IsOneOf(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

/// What a run's outcome puts its failure down to; nullopt where it did not fail.
std::optional<Problem> FailureOf(const std::string& outcome) {
  if (IsOneOf(outcome, {trial::kHandedOver, "delivered"})) return std::nullopt;
  if (IsOneOf(outcome, {"no_grasp", "no_path"})) return Problem::kPlanning;
  if (IsOneOf(outcome, {"not_lifted", "dropped", "misplaced"})) return Problem::kHand;
  if (IsOneOf(outcome, {"not_segmented", "wrong_target"})) return Problem::kRecognition;
  if (IsOneOf(outcome, {"felt_early", "not_felt", "not_taken"})) return Problem::kHandOver;
  return Problem::kOther;
}

struct Tally {
  int runs = 0, good = 0, carried = 0, felt = 0;
  std::array<int, kProblemRows.size()> events{}, influence{};
};

/// The runs of one kind of place: how far they came.
struct Place {
  const char* name;
  bool (*is_one)(const ordered_json& data);
};
/// Closer than this the dissertation asks nothing to stand ("a minimum distance of 20mm, equal to
/// the diameter of the thumb", section 4.1).
constexpr double kThumb_m = 0.020;
constexpr std::array<Place, 6> kPlaces = {{
    {"standing", [](const ordered_json& d) { return d.value("stands", false); }},
    {"lying",
     [](const ordered_json& d) { return d.contains("stands") && !d.value("stands", false); }},
    {"nothing within 20 mm",
     [](const ordered_json& d) { return d.value("clearance_m", 0.0) >= kThumb_m; }},
    {"something within 20 mm",
     [](const ordered_json& d) { return d.value("clearance_m", kThumb_m) < kThumb_m; }},
    {"touched by something", [](const ordered_json& d) { return d.value("touching", 0) > 0; }},
    {"all", [](const ordered_json&) { return true; }},
}};

/// The outcomes of a run's tries; its own where its record holds none.
std::vector<std::string> TriesOf(const experiment::Record& record, const ordered_json& data) {
  std::vector<std::string> outcomes;
  for (const auto& one : data.value("tries", ordered_json::array())) {
    outcomes.push_back(one.value("outcome", ""));
  }
  if (outcomes.empty()) outcomes.push_back(record.result.outcome);
  return outcomes;
}

ordered_json DataOf(const experiment::Record& record) {
  auto data = ordered_json::parse(record.result.data, nullptr, false);
  return data.is_object() ? data : ordered_json::object();
}

void Add(const experiment::Record& record, Tally& tally) {
  const ordered_json data = DataOf(record);
  const auto count = [](Problem problem, auto& counts) {
    ++counts[static_cast<std::size_t>(problem)];
  };
  ++tally.runs;
  bool hand = false;
  for (const std::string& outcome : TriesOf(record, data)) {
    const auto failure = FailureOf(outcome);
    if (!failure) continue;
    count(*failure, tally.events);
    hand = hand || *failure == Problem::kHand;
  }
  const auto influence = FailureOf(record.result.outcome);
  if (influence) {
    count(*influence, tally.influence);
  } else {
    ++tally.good;
  }
  // Fingers that shift others without any effect (section 4.4).
  if (data.value("others_moved", 0) > 0 && !hand) count(Problem::kHand, tally.events);
  const auto log = data.value("log", ordered_json::object());
  if (!log.contains("hand_over") || !log.value("held_after_carry", false)) return;
  ++tally.carried;
  tally.felt += log["hand_over"].value("felt", false) && !log["hand_over"].value("early", false);
}

std::string Percent(int k, int n) { return experiment::PercentText(k, n, 1); }

Grid ProblemGrid(const Tally& tally) {
  Grid grid;
  grid.header = {"problem", "events",    "with influence",       "% of runs",
                 "95 %",    "published", "published influence %"};
  grid.left = {true, false, false, false, false, false, false};
  int events = 0;
  int influence = 0;
  for (std::size_t i = 0; i < kProblemRows.size(); ++i) {
    events += tally.events[i];
    influence += tally.influence[i];
    grid.rows.push_back(
        {kProblemRows[i].name, fmt::format("{}", tally.events[i]),
         fmt::format("{}", tally.influence[i]), Percent(tally.influence[i], tally.runs),
         IntervalText(tally.influence[i], tally.runs), CountCell(kProblemRows[i].events),
         PercentCell(kProblemRows[i].influence)});
  }
  grid.rows.push_back({"sum", fmt::format("{}", events), fmt::format("{}", influence),
                       Percent(influence, tally.runs), IntervalText(influence, tally.runs),
                       CountCell(kSumRow.events), PercentCell(kSumRow.influence)});
  return grid;
}

void AddFigures(const ProblemRow& row, int events, int influence, int runs,
                std::vector<experiment::PublishedFigure>& figures) {
  using experiment::Count;
  const auto per_50 = [&](int count) {
    return runs > 0 ? std::optional(1.0 * kPublishedRuns * count / runs) : std::nullopt;
  };
  figures.push_back({.row = fmt::format("{}, events", row.name),
                     .unit = "in 50 runs",
                     .lower_is_better = true,
                     .published = static_cast<double>(*row.events),
                     .own = per_50(events),
                     .evidence = experiment::EventsEvidence{Count{events, runs},
                                                            Count{*row.events, kPublishedRuns}}});
  figures.push_back({.row = fmt::format("{}, runs that failed for it", row.name),
                     .unit = "in 50 runs",
                     .lower_is_better = true,
                     .published = static_cast<double>(*row.influence),
                     .own = per_50(influence),
                     .evidence = experiment::TrialsEvidence{
                         Count{influence, runs}, Count{*row.influence, kPublishedRuns}}});
}

// The sums count what the dissertation does not know, too: each run that failed.
std::vector<experiment::PublishedFigure> FiguresOf(const Tally& tally) {
  std::vector<experiment::PublishedFigure> figures;
  int events = 0;
  int influence = 0;
  for (std::size_t i = 0; i < kProblemRows.size(); ++i) {
    events += tally.events[i];
    influence += tally.influence[i];
    if (kProblemRows[i].events) {
      AddFigures(kProblemRows[i], tally.events[i], tally.influence[i], tally.runs, figures);
    }
  }
  AddFigures(kSumRow, events, influence, tally.runs, figures);
  return figures;
}

/// Table 4.2: seconds by the step of DetectCylinders; the sum of all without one.
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

// Medians of the runs with a single try: of more their sums are stored.
std::vector<experiment::PublishedFigure> TimesOf(const std::vector<experiment::Record>& records) {
  std::vector<experiment::PublishedFigure> figures;
  for (const StepRow& row : kSteps) {
    std::vector<double> all;
    for (const auto& record : records) {
      if (TriesOf(record, DataOf(record)).size() != 1) continue;
      double sum = 0.0;
      for (const auto& [stage, seconds] : record.result.seconds) {
        const std::string step = kCylinderStep + std::string(row.step);
        if (*row.step == '\0' ? stage.starts_with(step) : stage == step) sum += seconds;
      }
      if (sum > 0.0) all.push_back(sum);
    }
    figures.push_back({.row = row.name,
                       .unit = "s",
                       .digits = 4,
                       .lower_is_better = true,
                       .published = row.published_s,
                       .own = all.empty() ? std::nullopt : std::optional(base::MedianOf(all)),
                       .evidence = experiment::TimesEvidence{static_cast<int>(all.size())},
                       .key = "runtimes"});
  }
  return figures;
}

/// How far the runs came, by how the wanted cylinder lay.
Grid PlaceGrid(const std::vector<experiment::Record>& records) {
  Grid grid;
  grid.header = {"wanted cylinder",       "runs", "recognised", "carried",
                 "handed over or placed", "%",    "95 %"};
  grid.left = {true, false, false, false, false, false, false};
  for (const Place& place : kPlaces) {
    int runs = 0, recognised = 0, carried = 0, good = 0;
    for (const auto& record : records) {
      const ordered_json data = DataOf(record);
      if (!place.is_one(data)) continue;
      const auto failure = FailureOf(record.result.outcome);
      const auto log = data.value("log", ordered_json::object());
      ++runs;
      recognised += data.value("candidates", 0) > 0 && failure != Problem::kRecognition ? 1 : 0;
      carried += log.value("held_after_carry", false) ? 1 : 0;
      good += failure ? 0 : 1;
    }
    grid.rows.push_back({place.name, fmt::format("{}", runs), fmt::format("{}", recognised),
                         fmt::format("{}", carried), fmt::format("{}", good), Percent(good, runs),
                         IntervalText(good, runs)});
  }
  return grid;
}

/// "not_lifted 3, no_grasp 1"
std::string FailuresText(const std::vector<experiment::Record>& records) {
  std::map<std::string, int> counts;
  for (const auto& record : records) {
    if (FailureOf(record.result.outcome)) ++counts[record.result.outcome];
  }
  return counts.empty() ? "none" : experiment::CountsText(counts);
}

}  // namespace

std::string OutcomeOf(const trial::Attempt& attempt, Delivery delivery) {
  if (delivery == Delivery::kPlace) return std::string(base::Word(attempt.outcome));
  return trial::HandOverOutcome(attempt);
}

experiment::Report DemoReport(const experiment::Stamp&,
                              const std::vector<experiment::Record>& records) {
  Tally tally;
  for (const auto& record : records) Add(record, tally);
  experiment::Report report;
  report.csv = ProblemGrid(tally);
  report.sections.push_back({"", report.csv});
  report.sections.push_back({"how far the runs came", PlaceGrid(records)});
  report.notes.push_back(fmt::format(
      "published: 50 runs; {} of {} runs ended as they should ({} %, 95 %: {})", tally.good,
      tally.runs, Percent(tally.good, tally.runs), IntervalText(tally.good, tally.runs)));
  report.notes.push_back("failures: " + FailuresText(records));
  report.notes.push_back(
      "hand prosthesis: the object was not held, or another one was pushed by more than 5 mm");
  report.notes.push_back(
      "a problem has influence if the run failed for it; the others were got over by another try");
  if (tally.carried > 0) {
    report.notes.push_back(
        fmt::format("the pull was felt in {} of {} that were carried ({} %, 95 %: {})", tally.felt,
                    tally.carried, Percent(tally.felt, tally.carried),
                    IntervalText(tally.felt, tally.carried)));
  }
  ordered_json json = {{"runs", tally.runs},
                       {"good", tally.good},
                       {"carried", tally.carried},
                       {"felt", tally.felt},
                       {"problems", ordered_json::array()}};
  for (std::size_t i = 0; i < kProblemRows.size(); ++i) {
    json["problems"].push_back({{"problem", kProblemRows[i].name},
                                {"events", tally.events[i]},
                                {"with_influence", tally.influence[i]}});
  }
  json["stage_seconds"] = trial::JsonOf(experiment::StageTimes(records));
  report.json = json.dump();
  report.published = FiguresOf(tally);
  for (auto& figure : TimesOf(records)) report.published.push_back(std::move(figure));
  return report;
}

}  // namespace rangegrasp::cylinders
