#include "recognition/bring/bring_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/quantile.h"
#include "base/units.h"
#include "base/words.h"
#include "experiment/compare.h"
#include "experiment/stage_seconds.h"
#include "trial/hand_over.h"

namespace rangegrasp::bring {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using nlohmann::ordered_json;

/// "stays within 30 deg of upright".
constexpr double kUpright_rad = base::Deg(30.0);

ordered_json JsonOf(const Step& step) {
  ordered_json json = {{"at_wanted", step.at_wanted},
                       {"taken_for", step.taken_for},
                       {"grasp", step.grasp},
                       {"asked_upright", step.asked_upright ? ordered_json(*step.asked_upright)
                                                            : ordered_json(nullptr)},
                       {"touched_kept_free", step.touched_kept_free},
                       {"outcome", base::Word(step.attempt.outcome)},
                       {"stage", step.attempt.stage},
                       {"detail", step.attempt.detail}};
  json.update(trial::JsonOf(step.attempt));
  return json;
}

/// What the tables need of a run.
struct BroughtCase {
  std::string outcome, grasp;
  bool recorded = false, present = true;
  bool free = false;     ///< the hand was not on what is kept free
  bool upright = false;  ///< it had to stay upright
  bool stayed = false;   ///< and did
  int attempts = 0, looks = 0, cleared = 0;
  double robot_s = 0.0, compute_s = 0.0;
};

BroughtCase ReadCase(const experiment::Record& record) {
  BroughtCase one;
  one.outcome = record.result.outcome;
  const auto data = ordered_json::parse(record.result.data, nullptr, false);
  if (!data.is_object() || !data.contains("attempts")) return one;
  one.recorded = true;
  one.present = data.at("present");
  one.looks = data.at("looks");
  one.cleared = data.at("cleared");
  one.robot_s = data.at("simulated_s").get<double>() + data.at("homing_s").get<double>();
  one.attempts = static_cast<int>(data.at("attempts").size());
  for (const auto& [stage, seconds] : record.result.seconds) {
    if (stage == "bring") one.compute_s = seconds;
  }
  if (one.outcome != trial::kHandedOver) return one;
  const ordered_json& last = data.at("attempts").back();
  one.grasp = last.at("grasp").get<std::string>();
  if (one.grasp.empty()) one.grasp = last.at("grasp_type").get<std::string>();
  one.free = !last.at("touched_kept_free").get<bool>();
  one.upright = last.at("asked_upright").is_boolean() && last.at("asked_upright").get<bool>();
  one.stayed = one.upright && last.at("log").at("lean_rad").get<double>() <= kUpright_rad;
  return one;
}

struct Row {
  int runs = 0, good = 0, upright = 0, stayed = 0, named_or_free = 0, handed = 0, cleared = 0;
  int looks = 0, attempts = 0;
  std::map<std::string, int> otherwise, grasps;
  std::vector<double> robot_s, compute_s;
};

void Add(const BroughtCase& one, Row& row) {
  ++row.runs;
  const bool handed = one.outcome == trial::kHandedOver;
  const bool good = handed || one.outcome == kSaidAbsent;
  row.good += good ? 1 : 0;
  row.handed += handed ? 1 : 0;
  if (!good) ++row.otherwise[one.outcome];
  if (handed) ++row.grasps[one.grasp];
  row.named_or_free += handed && one.free ? 1 : 0;
  row.upright += one.upright ? 1 : 0;
  row.stayed += one.stayed ? 1 : 0;
  row.cleared += one.cleared;
  row.looks += one.looks;
  row.attempts += one.attempts;
  if (!one.recorded) return;
  row.robot_s.push_back(one.robot_s);
  row.compute_s.push_back(one.compute_s);
}

std::string Ratio(int k, int n) { return n == 0 ? "-" : Fixed(static_cast<double>(k) / n, 2); }

std::vector<std::string> CellsOf(const std::string& name, const Row& row) {
  return {name,
          fmt::format("{}", row.runs),
          fmt::format("{}", row.good),
          experiment::PercentText(row.good, row.runs, 1),
          IntervalText(row.good, row.runs),
          Ratio(row.attempts, row.runs),
          Ratio(row.cleared, row.runs),
          Ratio(row.looks, row.runs),
          row.upright == 0 ? "-" : fmt::format("{}/{}", row.stayed, row.upright),
          row.handed == 0 ? "-" : fmt::format("{}/{}", row.named_or_free, row.handed),
          experiment::CountsText(row.grasps),
          experiment::CountsText(row.otherwise)};
}

}  // namespace

experiment::Result ResultOf(const Bring& run, const std::string& wanted, bool present) {
  double simulated_s = run.moved_s;
  ordered_json attempts = ordered_json::array();
  std::vector<std::pair<std::string, double>> seconds = {{"look", run.look_s}};
  for (const Step& step : run.steps) {
    if (step.attempt.log) simulated_s += step.attempt.log->simulated_s;
    attempts.push_back(JsonOf(step));
    for (const auto& [stage, s] : step.attempt.seconds) {
      experiment::AddSeconds(stage, s, seconds);
    }
  }
  const ordered_json data = {
      {"wanted", wanted},
      {"present", present},
      {"said", base::Word(run.said)},
      {"friction", run.friction ? ordered_json(*run.friction) : ordered_json(nullptr)},
      {"words", run.words},
      {"looks", run.looks},
      {"cleared", run.cleared},
      {"simulated_s", simulated_s},
      {"homing_s", run.homing_s},
      {"attempts", attempts}};
  const std::string stage = run.steps.empty() ? "look" : run.steps.back().attempt.stage;
  return {run.outcome, stage, run.detail, data.dump(), seconds};
}

experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  std::vector<std::pair<std::string, Row>> rows;
  Row all;
  for (const auto& record : records) {
    const BroughtCase one = ReadCase(record);
    if (rows.empty() || rows.back().first != record.which.group) {
      rows.emplace_back(record.which.group, Row{});
    }
    Add(one, rows.back().second);
    Add(one, all);
  }
  Grid grid;
  grid.header = {"wanted",  "runs",           "as wanted",      "%",
                 "95 %",    "attempts / run", "cleared / run",  "looks / run",
                 "upright", "kept free",      "handed over by", "otherwise"};
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = grid.left[10] = grid.left[11] = true;
  for (const auto& [object, row] : rows) {
    grid.rows.push_back(CellsOf(experiment::TitleOf(stamp, object), row));
  }
  grid.rows.push_back(CellsOf("all", all));
  grid.total = true;
  experiment::Report report;
  report.sections.push_back({"", grid});
  report.csv = grid;
  report.notes.push_back(
      "as wanted: handed over; where it is not there: said so. Upright: of "
      "objects that stood upright those that stayed within 30 deg. Kept free: "
      "of those handed over the ones whose part for the person the hand left "
      "free");
  if (!all.robot_s.empty()) {
    report.notes.push_back(
        fmt::format("the arm moves for {:.0f} s a run (median); a run takes {:.1f} s of computing "
                    "(median), 95 % less than {:.1f} s",
                    base::MedianOf(all.robot_s), base::MedianOf(all.compute_s),
                    base::InterpolatedQuantileOf(all.compute_s, 0.95)));
  }
  return report;
}

}  // namespace rangegrasp::bring
