#include "times/task/times_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/statistics.h"
#include "base/words.h"

namespace rangegrasp::times {
namespace {

using experiment::Column;
using experiment::Grid;
using experiment::Record;
using experiment::Report;
using experiment::Stamp;

constexpr int kDigits = 4;  ///< decimals of seconds: a tenth of a millisecond
constexpr const char* kOwnFormat = ".4f";

// A row of table 5.1: the published steps and our own steps that it sums.
struct Stage {
  std::string title;
  std::vector<std::string> published;
  std::vector<std::string> own;
};

const std::vector<Stage>& Stages() {
  static const std::vector<Stage> stages = {
      {"plane fit", {"plane fit"}, {"sampling", "table"}},
      {"outlier filter, smoothing", {}, {"filter", "smooth"}},
      {"mesh generation and segmentation",
       {"mesh generation", "mesh segmentation"},
       {"normals", "segments"}},
      {"top surface detection", {"top surface detection"}, {"top surfaces"}},
      {"merging rotationally symmetric objects",
       {"merging rotationally symmetric objects"},
       {"merging"}},
      {"approximation of 3D objects", {"approximation of 3D objects"}, {"completion"}},
      {"grasping points and poses, collision detection",
       {"grasping point detection", "grasping pose detection", "collision detection"},
       {"grasp"}},
      {"sum", {"sum"}, {}}};  // its own time is the sum of all others
  return stages;
}

using ByStep = std::map<std::string, double>;

// Published seconds by step; empty without a reference.
ByStep PublishedSteps(const Stamp& stamp) {
  ByStep steps;
  const auto csv = experiment::ReferenceOf(stamp);
  for (std::size_t row = 0; csv && row < csv->rows(); ++row) {
    steps[csv->Cell(row, csv->Column("step"))] = csv->Number(row, csv->Column("seconds"));
  }
  return steps;
}

// The sum of those steps that exist; nullopt if none does.
std::optional<double> SumOf(const ByStep& steps, const std::vector<std::string>& names) {
  std::optional<double> sum;
  for (const std::string& name : names) {
    const auto found = steps.find(name);
    if (found != steps.end()) sum = sum.value_or(0.0) + found->second;
  }
  return sum;
}

// The times of a method in all scenes, by the row's title.
std::map<std::string, std::vector<double>> OwnTimes(const std::vector<Record>& records,
                                                    const std::string& group) {
  std::map<std::string, std::vector<double>> times;
  for (const Record& record : records) {
    if (record.which.group != group || record.result.seconds.empty()) continue;
    double total = 0.0;
    for (const Stage& stage : Stages()) {
      double sum = 0.0;
      for (const auto& [step, seconds] : record.result.seconds) {
        if (std::ranges::find(stage.own, step) != stage.own.end()) sum += seconds;
      }
      total += sum;
      times[stage.title].push_back(stage.own.empty() ? total : sum);
    }
  }
  return times;
}

std::optional<double> MedianOf(const std::vector<double>& all) {
  if (all.empty()) return std::nullopt;
  return base::MedianOf(all);
}

experiment::PublishedFigure FigureOf(const std::string& row, double published,
                                     std::optional<double> own, int measured) {
  return {.row = row,
          .unit = "s",
          .digits = kDigits,
          .lower_is_better = true,
          .published = published,
          .own = own,
          .evidence = experiment::TimesEvidence{measured}};
}

Report StagesReport(const Stamp& stamp, const std::vector<Record>& records) {
  const ByStep steps = PublishedSteps(stamp);
  const auto published = [&](const Stage& stage) { return SumOf(steps, stage.published); };
  Report report;
  std::vector<Column<Stage>> columns = {{"calculation step", "", &Stage::title, experiment::kLeft},
                                        {"dissertation [s]", ".1f", published}};
  for (const std::string& group : GroupsOf(records)) {
    const auto own = [times = OwnTimes(records, group)](const Stage& stage) {
      const auto found = times.find(stage.title);
      return found == times.end() ? std::vector<double>() : found->second;
    };
    columns.push_back(
        {group + " [s]", kOwnFormat, [own](const Stage& stage) { return MedianOf(own(stage)); }});
    for (const Stage& stage : Stages()) {
      const auto known = published(stage);
      if (!known) continue;
      report.published.push_back(FigureOf(fmt::format("{}, method {}", stage.title, group), *known,
                                          MedianOf(own(stage)),
                                          static_cast<int>(own(stage).size())));
    }
  }
  Grid grid = experiment::GridOf(columns, Stages());
  grid.total = true;
  report.sections.push_back({"Table 5.1: times of the calculation steps", grid});
  report.notes.push_back(
      "here: median over the scenes, with grasps for all objects; the median of the sum is not the "
      "sum of the medians; published: 2 GHz Core 2 Duo");
  report.csv = grid;
  return report;
}

// A scene of figures 5.8 and 5.9.
struct SceneTimes {
  int scene = 0, object_points = 0, table_points = 0;
  std::map<std::string, std::vector<double>> measured;  // seconds by segmentation, of each seed
  ByStep own;                                           // their medians
  ByStep published;                                     // the published times
};

std::vector<SceneTimes> ScenesOf(const Stamp& stamp, const std::vector<Record>& records) {
  std::map<int, SceneTimes> scenes;
  for (const Record& record : records) {
    const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.contains("scene")) continue;
    SceneTimes& one = scenes[data.at("scene")];
    one.scene = data.at("scene");
    one.object_points = data.at("object_points");
    one.table_points = data.at("table_points");
    for (const auto& [step, seconds] : record.result.seconds) {
      if (step == "segments") one.measured[record.which.group].push_back(seconds);
    }
  }
  const auto csv = experiment::ReferenceOf(stamp);
  std::vector<SceneTimes> list;
  for (auto& [number, one] : scenes) {
    for (const auto& [method, seconds] : one.measured) one.own[method] = base::MedianOf(seconds);
    const auto row = static_cast<std::size_t>(number - 1);
    if (csv && row < csv->rows()) {
      one.published = {{"region_growing", csv->Number(row, csv->Column("region_growing_s"))},
                       {"mesh", csv->Number(row, csv->Column("mesh_segmentation_s"))}};
    }
    list.push_back(one);
  }
  return list;
}

Grid SceneGrid(const std::vector<SceneTimes>& scenes, const std::vector<std::string>& methods,
               bool csv) {
  std::vector<Column<SceneTimes>> columns = {
      {"scene", "", &SceneTimes::scene},
      {csv ? "object_points" : "object points", "", &SceneTimes::object_points},
      {csv ? "table_points" : "table points", "", &SceneTimes::table_points}};
  for (const std::string& method : methods) {
    columns.push_back({method + (csv ? "_s" : " [s]"), kOwnFormat,
                       [method](const SceneTimes& one) { return SumOf(one.own, {method}); }});
    columns.push_back({csv ? "published_" + method + "_s" : "dissertation [s]", ".3f",
                       [method](const SceneTimes& one) { return SumOf(one.published, {method}); }});
  }
  return experiment::GridOf(columns, scenes, csv ? "" : "-");
}

Report SegmentationsReport(const Stamp& stamp, const std::vector<Record>& records) {
  const auto scenes = ScenesOf(stamp, records);
  const auto methods = GroupsOf(records);
  Report report;
  for (const SceneTimes& one : scenes) {
    for (const std::string& method : methods) {
      const auto published = SumOf(one.published, {method});
      if (!published) continue;
      const auto found = one.measured.find(method);
      const auto seeds = found == one.measured.end() ? 0 : static_cast<int>(found->second.size());
      report.published.push_back(FigureOf(fmt::format("scene {}, {}", one.scene, method),
                                          *published, SumOf(one.own, {method}), seeds));
    }
  }
  report.sections.push_back(
      {"Figures 5.8 and 5.9: times of the segmentations", SceneGrid(scenes, methods, false)});
  report.notes.push_back(
      "here: segmentation only, without the normals that region growing needs; median of the "
      "repeats, and of the seeds; published: 2 GHz Core 2 Duo");
  report.csv = SceneGrid(scenes, methods, true);
  return report;
}

}  // namespace

Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const std::string& timed = experiment::Need(stamp.data, kTimed);
  return timed == base::Word(Timed::kStages) ? StagesReport(stamp, records)
                                             : SegmentationsReport(stamp, records);
}

}  // namespace rangegrasp::times
