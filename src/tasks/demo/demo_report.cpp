#include "tasks/demo/demo_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/words.h"
#include "experiment/compare.h"
#include "experiment/statistics.h"

namespace rangegrasp::tasks::demo {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using nlohmann::ordered_json;

/// The kinds of table 4.1, and what it does not count.
enum class Problem { kPlanning, kHand, kRecognition, kHandOver, kOther };
struct ProblemRow {
  const char* name;
  const char* published_events;  // in 50 runs
  const char* published_percent;
};
constexpr std::array<ProblemRow, 5> kRows = {{
    {"path planning", "11", "22"},
    {"hand prosthesis", "4", "0"},
    {"object recognition", "2", "4"},
    {"handing over", "-", "-"},
    {"simulation", "-", "-"},
}};

bool IsOneOf(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

/// What a run's outcome puts its failure down to; nullopt where it did not fail.
std::optional<Problem> FailureOf(const std::string& outcome) {
  if (IsOneOf(outcome, {kHandedOver, "delivered"})) return std::nullopt;
  if (IsOneOf(outcome, {"no_grasp", "no_path"})) return Problem::kPlanning;
  if (IsOneOf(outcome, {"not_lifted", "dropped", "misplaced"})) return Problem::kHand;
  if (IsOneOf(outcome, {"not_segmented", "wrong_target"})) return Problem::kRecognition;
  if (IsOneOf(outcome, {"felt_early", "not_felt", "not_taken"})) return Problem::kHandOver;
  return Problem::kOther;
}

struct Tally {
  int runs = 0, good = 0, carried = 0, felt = 0;
  std::array<int, kRows.size()> events{}, influence{};
};

void Add(const experiment::Record& record, Tally& tally) {
  ++tally.runs;
  const auto failure = FailureOf(record.result.outcome);
  if (failure) {
    ++tally.events[static_cast<std::size_t>(*failure)];
    ++tally.influence[static_cast<std::size_t>(*failure)];
  } else {
    ++tally.good;
  }
  const auto data = ordered_json::parse(record.result.data, nullptr, false);
  if (!data.is_object()) return;
  // Fingers that shift others without any effect (section 4.4).
  const bool pushed = data.value("others_moved", 0) > 0;
  if (pushed && failure != Problem::kHand) {
    ++tally.events[static_cast<std::size_t>(Problem::kHand)];
  }
  const auto log = data.value("log", ordered_json::object());
  if (!log.contains("hand_over")) return;
  ++tally.carried;
  tally.felt += log["hand_over"].value("felt", false) && !log["hand_over"].value("early", false);
}

std::string Percent(int k, int n) { return n == 0 ? "-" : Fixed(100.0 * k / n, 1); }

Grid ProblemGrid(const Tally& tally) {
  Grid grid;
  grid.header = {"problem", "events",    "with influence",       "% of runs",
                 "95 %",    "published", "published influence %"};
  grid.left = {true, false, false, false, false, false, false};
  int events = 0;
  int influence = 0;
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    events += tally.events[i];
    influence += tally.influence[i];
    grid.rows.push_back(
        {kRows[i].name, fmt::format("{}", tally.events[i]), fmt::format("{}", tally.influence[i]),
         Percent(tally.influence[i], tally.runs), IntervalText(tally.influence[i], tally.runs),
         kRows[i].published_events, kRows[i].published_percent});
  }
  grid.rows.push_back({"sum", fmt::format("{}", events), fmt::format("{}", influence),
                       Percent(influence, tally.runs), IntervalText(influence, tally.runs), "17",
                       "26"});
  return grid;
}

}  // namespace

std::string OutcomeOf(const grasping::Attempt& attempt, Delivery delivery) {
  using grasping::Outcome;
  const std::string word(core::Word(attempt.outcome));
  if (delivery == Delivery::kPlace || !attempt.log || !attempt.log->hand_over) return word;
  if (attempt.outcome == Outcome::kInvalidPhysics || attempt.outcome == Outcome::kCrashed) {
    return word;
  }
  const sim::HandOverLog& log = *attempt.log->hand_over;
  if (log.early) return "felt_early";
  if (!log.felt) return "not_felt";
  return log.taken ? kHandedOver : "not_taken";
}

experiment::Report ReportOf(const experiment::Stamp&,
                            const std::vector<experiment::Record>& records) {
  Tally tally;
  for (const auto& record : records) Add(record, tally);
  experiment::Report report;
  report.csv = ProblemGrid(tally);
  report.sections.push_back({"", report.csv});
  report.notes.push_back(fmt::format(
      "published: 50 runs; {} of {} runs ended as they should ({} %, 95 %: {})", tally.good,
      tally.runs, Percent(tally.good, tally.runs), IntervalText(tally.good, tally.runs)));
  if (tally.carried > 0) {
    report.notes.push_back(fmt::format("the pull was felt in {} of {} that were carried ({} %)",
                                       tally.felt, tally.carried,
                                       Percent(tally.felt, tally.carried)));
  }
  ordered_json json = {{"runs", tally.runs},
                       {"good", tally.good},
                       {"carried", tally.carried},
                       {"felt", tally.felt},
                       {"problems", ordered_json::array()}};
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    json["problems"].push_back({{"problem", kRows[i].name},
                                {"events", tally.events[i]},
                                {"with_influence", tally.influence[i]}});
  }
  json["stage_seconds"] = ordered_json::object();
  for (const auto& time : experiment::StageTimes(records)) {
    json["stage_seconds"][time.stage] = {{"median", time.median_s}, {"p95", time.p95_s}};
  }
  report.json = json.dump();
  return report;
}

}  // namespace rangegrasp::tasks::demo
