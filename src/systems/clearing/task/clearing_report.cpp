#include "clearing/task/clearing_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/statistics.h"
#include "base/words.h"
#include "experiment/statistics.h"
#include "trial/table.h"

namespace rangegrasp::clearing {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using nlohmann::ordered_json;
using Counts = std::map<std::string, int>;

ordered_json JsonOf(const Clearing& clearing, const Step& step) {
  const auto name = [&](int object) {
    return clearing.objects[static_cast<std::size_t>(object)].object;
  };
  ordered_json taken = ordered_json::array();
  for (const int object : step.taken_away) taken.push_back(name(object));
  ordered_json json = {
      {"scan", step.scan},
      {"object", step.attempt.target ? ordered_json(name(*step.attempt.target)) : nullptr},
      {"held", step.attempt.log ? ordered_json(name(step.attempt.log->target)) : nullptr},
      {"try", step.try_number},
      {"outcome", base::Word(step.attempt.outcome)},
      {"stage", step.attempt.stage},
      {"detail", step.attempt.detail},
      {"felt", step.felt},
      {"taken_away", taken}};
  json.update(trial::JsonOf(step.attempt));
  return json;
}

// Each stage's sum, in the order in which they first occur.
std::vector<std::pair<std::string, double>> SumsOf(const Clearing& clearing) {
  std::vector<std::pair<std::string, double>> sums = {{"scan", clearing.scan_s}};
  for (const Step& step : clearing.steps) {
    for (const auto& [stage, seconds] : step.attempt.seconds) {
      experiment::AddSeconds(stage, seconds, sums);
    }
  }
  return sums;
}

// What the tables need of a stored run. Of one without data (crashed, timed out) no object was
// delivered.
struct ClearedCase {
  std::string outcome;
  bool recorded = false;  // not of one that crashed or timed out
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0, attempts = 0;
  double robot_s = 0.0;  // simulated, with the ways home
  std::map<std::string, double> seconds;
  std::vector<ObjectEnd> ends;
  Counts grasp_outcomes;
  int felt_wrong = 0;  // grasps in which the hand's feeling and the target's delivery disagree
};

ClearedCase ReadCase(const experiment::Record& record) {
  ClearedCase read;
  read.outcome = record.result.outcome;
  for (const auto& [stage, seconds] : record.result.seconds) read.seconds[stage] += seconds;
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  if (!data.is_object() || !data.contains("per_object")) {
    read.objects = record.which.params.Has("objects") ? record.which.params.Int("objects") : 0;
    return read;
  }
  read.recorded = true;
  read.objects = data.at("objects");
  read.delivered = data.at("delivered");
  read.brought = data.at("brought");
  read.grasps = data.at("grasps");
  read.scans = data.at("scans");
  read.robot_s = data.at("simulated_s").get<double>() + data.at("homing_s").get<double>();
  for (const auto& end : data.at("per_object")) {
    read.ends.push_back({end.at("object"),
                         base::FromWord<Fate>(end.at("fate").get<std::string>(), "fate"),
                         end.at("grasps"), end.at("why")});
  }
  for (const auto& attempt : data.at("attempts")) {
    ++read.attempts;
    if (attempt.at("log").empty()) continue;
    const std::string outcome = attempt.at("outcome");
    ++read.grasp_outcomes[outcome];
    read.felt_wrong += attempt.at("felt").get<bool>() != (outcome == "delivered") ? 1 : 0;
  }
  return read;
}

// All runs of one arrangement.
struct Category {
  std::string name;
  int runs = 0, failed = 0;  // failed: crashed or timed out, without a record
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0, felt_wrong = 0;
  std::vector<experiment::Count> clusters;
  std::vector<double> robot_s;
  struct OfObject {
    int runs = 0, delivered = 0, grasps = 0;
    Counts why;
  };
  std::map<std::string, OfObject> by_object;
  Counts outcomes, left, grasp_outcomes;
  std::vector<ClearedCase> cases;
};

void Add(const experiment::Record& record, Category& category) {
  const ClearedCase one = ReadCase(record);
  ++category.runs;
  ++category.outcomes[one.outcome];
  category.cases.push_back(one);
  category.objects += one.objects;
  if (!one.recorded) {
    ++category.failed;
    if (one.objects > 0) category.clusters.push_back({0, one.objects});
    return;
  }
  category.delivered += one.delivered;
  category.brought += one.brought;
  category.grasps += one.grasps;
  category.scans += one.scans;
  category.clusters.push_back({one.delivered, one.objects});
  category.robot_s.push_back(one.robot_s);
  category.felt_wrong += one.felt_wrong;
  for (const auto& [word, count] : one.grasp_outcomes) category.grasp_outcomes[word] += count;
  for (const ObjectEnd& end : one.ends) {
    auto& object = category.by_object[end.object];
    ++object.runs;
    object.grasps += end.grasps;
    if (end.fate == Fate::kDelivered) {
      ++object.delivered;
      continue;
    }
    const std::string why = fmt::format("{}: {}", base::Word(end.fate), end.why);
    ++object.why[why];
    ++category.left[why];
  }
}

// In the order in which they first occur.
std::vector<Category> CategoriesOf(const std::vector<experiment::Record>& records) {
  std::vector<Category> categories;
  for (const auto& record : records) {
    const std::string& group = record.which.group;
    auto found = std::ranges::find(categories, group, &Category::name);
    if (found == categories.end()) {
      found = categories.insert(categories.end(), Category{});
      found->name = group;
    }
    Add(record, *found);
  }
  return categories;
}

std::string Percent(int k, int n) { return experiment::PercentText(k, n, 2); }
std::string Ratio(int k, int n) { return n == 0 ? "-" : Fixed(static_cast<double>(k) / n, 2); }

std::string IntervalOf(const Category& category) {
  if (category.objects == 0) return "-";
  const auto [low, high] = experiment::ClusteredInterval(category.clusters);
  return fmt::format("{}-{}", Fixed(100.0 * low, 1), Fixed(100.0 * high, 1));
}

Grid MainGrid(const std::vector<Category>& categories) {
  Grid grid;
  grid.header = {"arrangement", "runs", "objects", "delivered",
                 "delivered %", "95 %", "grasps",  "grasps / delivered",
                 "scans / run", "ends"};
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = grid.left.back() = true;
  for (const Category& c : categories) {
    grid.rows.push_back({c.name, fmt::format("{}", c.runs), fmt::format("{}", c.objects),
                         fmt::format("{}", c.delivered), Percent(c.delivered, c.objects),
                         IntervalOf(c), fmt::format("{}", c.grasps), Ratio(c.grasps, c.delivered),
                         Ratio(c.scans, c.runs - c.failed), experiment::CountsText(c.outcomes)});
  }
  return grid;
}

Grid ObjectGrid(const experiment::Stamp& stamp, const Category& category) {
  Grid grid;
  grid.header = {"object", "runs", "delivered", "delivered %", "95 %", "grasps / run", "otherwise"};
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = grid.left.back() = true;
  for (const auto& [object, of] : category.by_object) {
    grid.rows.push_back({experiment::TitleOf(stamp, object), fmt::format("{}", of.runs),
                         fmt::format("{}", of.delivered), Percent(of.delivered, of.runs),
                         IntervalText(of.delivered, of.runs), Ratio(of.grasps, of.runs),
                         experiment::CountsText(of.why)});
  }
  return grid;
}

// Of one attempt, by the stages that each has; of a run its arrangement and the whole.
std::string TimesLine(const Category& category) {
  std::map<std::string, std::vector<double>> each;
  for (const ClearedCase& one : category.cases) {
    for (const auto& [stage, seconds] : one.seconds) {
      if (stage.find(':') != std::string::npos) continue;
      const int parts = stage == "arrange" || stage == "clearing" ? 1
                        : stage == "scan"                         ? one.scans
                        : stage == "execute"                      ? one.grasps
                                                                  : one.attempts;
      if (parts > 0) each[stage].push_back(seconds / parts);
    }
  }
  std::string line = category.name + ": seconds of computing, median of the runs' means, of one";
  for (const char* stage :
       {"scan", "perceive", "grasp", "obstacles", "plan", "execute", "arrange", "clearing"}) {
    const auto found = each.find(stage);
    if (found == each.end()) continue;
    line += fmt::format(" {} {:.3f}", stage, base::MedianOf(found->second));
  }
  return line;
}

std::string RobotLine(const Category& c) {
  if (c.robot_s.empty()) return c.name + ": no run has a record";
  return fmt::format(
      "{}: the arm moves for {:.0f} s a run (median), {:.1f} s a grasp; the hand's feeling was "
      "wrong in {} of {} grasps; brought otherwise {}",
      c.name, base::MedianOf(c.robot_s),
      std::accumulate(c.robot_s.begin(), c.robot_s.end(), 0.0) / std::max(1, c.grasps),
      c.felt_wrong, c.grasps, c.brought);
}

ordered_json JsonOf(const Category& c) {
  ordered_json json = {{"arrangement", c.name},      {"runs", c.runs},
                       {"without_record", c.failed}, {"objects", c.objects},
                       {"delivered", c.delivered},   {"brought", c.brought},
                       {"grasps", c.grasps},         {"scans", c.scans},
                       {"ends", c.outcomes},         {"grasp_outcomes", c.grasp_outcomes},
                       {"felt_wrong", c.felt_wrong}, {"not_delivered", c.left}};
  json["delivered_share"] = nullptr;
  json["delivered_interval"] = nullptr;
  json["robot_seconds_per_run"] = nullptr;
  if (c.objects > 0) {
    const auto [low, high] = experiment::ClusteredInterval(c.clusters);
    json["delivered_share"] = static_cast<double>(c.delivered) / c.objects;
    json["delivered_interval"] = {low, high};
    if (!c.robot_s.empty()) json["robot_seconds_per_run"] = base::MedianOf(c.robot_s);
  }
  json["by_object"] = ordered_json::array();
  for (const auto& [object, of] : c.by_object) {
    json["by_object"].push_back({{"object", object},
                                 {"runs", of.runs},
                                 {"delivered", of.delivered},
                                 {"grasps", of.grasps},
                                 {"otherwise", of.why}});
  }
  return json;
}

Grid CountGrid(const std::vector<Category>& categories, const std::string& what,
               Counts Category::*counts) {
  Grid grid;
  grid.header = {"arrangement", what, "count"};
  grid.left = {true, true, false};
  for (const Category& c : categories) {
    for (const auto& [word, count] : c.*counts) {
      grid.rows.push_back({c.name, word, fmt::format("{}", count)});
    }
  }
  return grid;
}

}  // namespace

experiment::Result ResultOf(const Clearing& clearing, const std::string& target) {
  double simulated_s = 0.0;
  ordered_json attempts = ordered_json::array();
  for (const Step& step : clearing.steps) {
    if (step.attempt.log) simulated_s += step.attempt.log->simulated_s;
    attempts.push_back(JsonOf(clearing, step));
  }
  ordered_json per_object = ordered_json::array();
  for (const ObjectEnd& end : clearing.objects) {
    per_object.push_back({{"object", end.object},
                          {"fate", base::Word(end.fate)},
                          {"grasps", end.grasps},
                          {"why", end.why}});
  }
  const ordered_json data = {{"target", target},
                             {"objects", clearing.objects.size()},
                             {"delivered", clearing.Count(Fate::kDelivered)},
                             {"brought", clearing.Count(Fate::kBrought)},
                             {"left", clearing.Count(Fate::kLeft)},
                             {"grasps", clearing.Grasps()},
                             {"scans", clearing.scans},
                             {"perceived", clearing.perceived},
                             {"stop", base::Word(clearing.stop)},
                             {"simulated_s", simulated_s},
                             {"homing_s", clearing.homing_s},
                             {"per_object", per_object},
                             {"attempts", attempts}};
  const bool cleared =
      clearing.Count(Fate::kDelivered) == static_cast<int>(clearing.objects.size());
  return {cleared ? kCleared : std::string(base::Word(clearing.stop)), "clear", clearing.detail,
          data.dump(), SumsOf(clearing)};
}

experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  const auto categories = CategoriesOf(records);
  experiment::Report report;
  report.sections.push_back({"", MainGrid(categories)});
  for (const Category& c : categories) {
    report.sections.push_back({c.name + ", by object", ObjectGrid(stamp, c)});
  }
  report.sections.push_back(
      {"Objects that were not delivered", CountGrid(categories, "why", &Category::left)});
  report.sections.push_back(
      {"Grasps", CountGrid(categories, "outcome", &Category::grasp_outcomes)});
  ordered_json json;
  json["arrangements"] = ordered_json::array();
  for (const Category& c : categories) {
    report.notes.push_back(RobotLine(c));
    report.notes.push_back(TimesLine(c));
    json["arrangements"].push_back(JsonOf(c));
  }
  json["stage_seconds"] = trial::JsonOf(experiment::StageTimes(records));
  report.json = json.dump();
  report.csv = MainGrid(categories);
  return report;
}

}  // namespace rangegrasp::clearing
