#include "clearing/clearing_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/quantile.h"
#include "base/words.h"
#include "clearing/clearing_record.h"
#include "experiment/compare.h"
#include "experiment/statistics.h"
#include "trial/table.h"

namespace rangegrasp::clearing {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using nlohmann::ordered_json;
using Counts = std::map<std::string, int>;

/// All runs of one arrangement.
struct Category {
  std::string name;
  int runs = 0, failed = 0;  ///< failed: crashed or timed out, without a record
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0;
  std::vector<experiment::Cluster> clusters;
  Counts outcomes;
  std::vector<double> robot_s;
  struct OfObject {
    int runs = 0, delivered = 0, grasps = 0;
    Counts why;
  };
  std::map<std::string, OfObject> by_object;
  Counts left, grasp_outcomes;
  int felt_wrong = 0;
  std::vector<experiment::Record> records;
};

void Add(const experiment::Record& record, Category& category) {
  const ClearedCase one = ReadCase(record);
  ++category.runs;
  ++category.outcomes[one.outcome];
  category.records.push_back(record);
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
    auto found = std::find_if(categories.begin(), categories.end(),
                              [&](const Category& c) { return c.name == group; });
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
  for (const auto& record : category.records) {
    const ClearedCase one = ReadCase(record);
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
