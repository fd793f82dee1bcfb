#include "clearing/task/clearing_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <ranges>

#include "base/statistics.h"
#include "base/words.h"
#include "experiment/statistics.h"
#include "trial/table.h"

namespace rangegrasp::clearing {
namespace {

using Counts = std::map<std::string, int>;
using experiment::Column;
using experiment::Fixed;
using experiment::Grid;
using experiment::Record;
using experiment::Stamp;
using nlohmann::ordered_json;

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

// Sum of the times of each stage, in the order of first occurrence.
std::vector<std::pair<std::string, double>> SumsOf(const Clearing& clearing) {
  std::vector<std::pair<std::string, double>> sums = {{"scan", clearing.scan_s}};
  for (const Step& step : clearing.steps) {
    for (const auto& [stage, seconds] : step.attempt.seconds) {
      experiment::AddSeconds(stage, seconds, sums);
    }
  }
  return sums;
}

struct OfObject {
  std::string name;
  int runs = 0, delivered = 0, grasps = 0;
  Counts why;
};

// All runs of one arrangement.
struct Category {
  std::string name;
  int runs = 0, failed = 0;  // failed: crashed or timed out, without a record
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0;
  int felt_wrong = 0;  // grasps for which the hand's aperture and the target's delivery disagree
  std::vector<experiment::Count> clusters;
  std::vector<double> robot_s;  // of each run: simulated time and motions home
  std::map<std::string, OfObject> by_object;
  Counts outcomes, left, grasp_outcomes;
};

void AddEnd(const nlohmann::json& end, Category& category) {
  const std::string name = end.at("object");
  const std::string fate = end.at("fate");
  OfObject& object = category.by_object[name];
  object.name = name;
  ++object.runs;
  object.grasps += end.at("grasps").get<int>();
  if (fate == base::Word(Fate::kDelivered)) {
    ++object.delivered;
    return;
  }
  const std::string why = fate + ": " + end.at("why").get<std::string>();
  ++object.why[why];
  ++category.left[why];
}

// Adds a record. A run without data (crashed, timed out) counts as one that delivered no object.
void Add(const Record& record, Category& category) {
  ++category.runs;
  ++category.outcomes[record.result.outcome];
  const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
  const auto number = [&](const char* name) { return data.at(name).get<int>(); };
  if (!data.is_object() || !data.contains("per_object")) {
    ++category.failed;
    if (!record.which.params.Has("objects")) return;
    const int objects = record.which.params.Int("objects");
    category.objects += objects;
    if (objects > 0) category.clusters.push_back({0, objects});
    return;
  }
  category.objects += number("objects");
  category.delivered += number("delivered");
  category.brought += number("brought");
  category.grasps += number("grasps");
  category.scans += number("scans");
  category.clusters.push_back({number("delivered"), number("objects")});
  category.robot_s.push_back(data.at("simulated_s").get<double>() +
                             data.at("homing_s").get<double>());
  for (const auto& end : data.at("per_object")) AddEnd(end, category);
  for (const auto& attempt : data.at("attempts")) {
    if (attempt.at("log").empty()) continue;
    const std::string outcome = attempt.at("outcome");
    ++category.grasp_outcomes[outcome];
    category.felt_wrong += attempt.at("felt").get<bool>() != (outcome == "delivered") ? 1 : 0;
  }
}

// The categories in the order of first occurrence.
std::vector<Category> CategoriesOf(const std::vector<Record>& records) {
  std::vector<Category> categories;
  for (const std::string& group : GroupsOf(records)) {
    categories.emplace_back().name = group;
    for (const Record& record : records) {
      if (record.which.group == group) Add(record, categories.back());
    }
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
  const std::vector<Column<Category>> columns = {
      {"arrangement", "", &Category::name, experiment::kLeft},
      {"runs", "", &Category::runs},
      {"objects", "", &Category::objects},
      {"delivered", "", &Category::delivered},
      {"delivered %", "", [](const Category& c) { return Percent(c.delivered, c.objects); }},
      {"95 %", "", IntervalOf},
      {"grasps", "", &Category::grasps},
      {"grasps / delivered", "", [](const Category& c) { return Ratio(c.grasps, c.delivered); }},
      {"scans / run", "", [](const Category& c) { return Ratio(c.scans, c.runs - c.failed); }},
      {"ends", "", [](const Category& c) { return experiment::CountsText(c.outcomes); },
       experiment::kLeft}};
  return experiment::GridOf(columns, categories);
}

Grid ObjectGrid(const Stamp& stamp, const Category& category) {
  const std::vector<Column<OfObject>> columns = {
      {"object", "", [&](const OfObject& o) { return experiment::TitleOf(stamp, o.name); },
       experiment::kLeft},
      {"runs", "", &OfObject::runs},
      {"delivered", "", &OfObject::delivered},
      {"delivered %", "", [](const OfObject& o) { return Percent(o.delivered, o.runs); }},
      {"95 %", "", [](const OfObject& o) { return experiment::IntervalText(o.delivered, o.runs); }},
      {"grasps / run", "", [](const OfObject& o) { return Ratio(o.grasps, o.runs); }},
      {"otherwise", "", [](const OfObject& o) { return experiment::CountsText(o.why); },
       experiment::kLeft}};
  return experiment::GridOf(columns, std::views::values(category.by_object));
}

std::string RobotLine(const Category& c) {
  if (c.robot_s.empty()) return c.name + ": no run has a record";
  return fmt::format(
      "{}: the arm moves for {:.0f} s per run (median), {:.1f} s per grasp; the hand's sensors "
      "were wrong in {} of {} grasps; objects delivered in another way: {}",
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
                       {"felt_wrong", c.felt_wrong}, {"not_delivered", c.left},
                       {"delivered_share", nullptr}, {"delivered_interval", nullptr}};
  if (c.objects > 0) {
    json["delivered_share"] = static_cast<double>(c.delivered) / c.objects;
    json["delivered_interval"] = experiment::ClusteredInterval(c.clusters);
  }
  json["robot_seconds_per_run"] = nullptr;
  if (!c.robot_s.empty()) json["robot_seconds_per_run"] = base::MedianOf(c.robot_s);
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

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
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
    json["arrangements"].push_back(JsonOf(c));
  }
  json["stage_seconds"] = trial::JsonOf(experiment::StageTimes(records));
  report.json = json.dump();
  report.csv = MainGrid(categories);
  return report;
}

}  // namespace rangegrasp::clearing
