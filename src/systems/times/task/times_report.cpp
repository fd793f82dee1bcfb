#include "times/task/times_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/draw/plot.h"
#include "base/file.h"
#include "base/statistics.h"
#include "base/words.h"

namespace rangegrasp::times {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::Record;

constexpr int kDigits = 4;  ///< of seconds: a tenth of a millisecond

// A row of table 5.1: what it sums of the published steps and of the own ones.
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
       {"grasp"}}};
  return stages;
}

using ByStep = std::map<std::string, double>;

std::optional<base::CsvTable> ReferenceOf(const experiment::Stamp& stamp) {
  const auto text = stamp.data.find(kReference);
  if (text == stamp.data.end()) return std::nullopt;
  return base::CsvTable::Parse(text->second, "reference table");
}

// Published seconds by step; empty without a reference.
ByStep PublishedSteps(const experiment::Stamp& stamp) {
  ByStep steps;
  const auto csv = ReferenceOf(stamp);
  for (std::size_t row = 0; csv && row < csv->rows(); ++row) {
    steps[csv->Cell(row, csv->Column("step"))] = csv->Number(row, csv->Column("seconds"));
  }
  return steps;
}

// Of those steps that are there; nothing where none is.
std::optional<double> SumOf(const ByStep& steps, const std::vector<std::string>& names) {
  std::optional<double> sum;
  for (const std::string& name : names) {
    const auto found = steps.find(name);
    if (found != steps.end()) sum = sum.value_or(0.0) + found->second;
  }
  return sum;
}

std::string Text(const std::optional<double>& seconds, int digits) {
  return seconds ? Fixed(*seconds, digits) : "-";
}

// Of a method: each row's times in all scenes, and the sums.
std::vector<std::vector<double>> OwnTimes(const std::vector<Record>& records,
                                          const std::string& group) {
  std::vector<std::vector<double>> rows(Stages().size() + 1);
  for (const Record& record : records) {
    if (record.which.group != group || record.result.seconds.empty()) continue;
    double total = 0.0;
    for (std::size_t i = 0; i < Stages().size(); ++i) {
      double sum = 0.0;
      for (const auto& [step, seconds] : record.result.seconds) {
        const auto& own = Stages()[i].own;
        if (std::ranges::find(own, step) != own.end()) sum += seconds;
      }
      rows[i].push_back(sum);
      total += sum;
    }
    rows.back().push_back(total);
  }
  return rows;
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

experiment::Report StagesReport(const experiment::Stamp& stamp,
                                const std::vector<Record>& records) {
  const ByStep published = PublishedSteps(stamp);
  experiment::Report report;
  Grid grid;
  grid.header = {"calculation step", "published [s]"};
  for (const Stage& stage : Stages()) {
    grid.rows.push_back({stage.title, Text(SumOf(published, stage.published), 1)});
  }
  grid.rows.push_back({"sum", Text(SumOf(published, {"sum"}), 1)});
  for (const std::string& group : GroupsOf(records)) {
    grid.header.push_back(group + " [s]");
    const auto times = OwnTimes(records, group);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto median = MedianOf(times[i]);
      grid.rows[i].push_back(Text(median, kDigits));
      const auto known =
          i < Stages().size() ? SumOf(published, Stages()[i].published) : SumOf(published, {"sum"});
      if (!known) continue;
      report.published.push_back(FigureOf(fmt::format("{}, method {}", grid.rows[i][0], group),
                                          *known, median, static_cast<int>(times[i].size())));
    }
  }
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = true;
  grid.total = true;
  report.sections.push_back({"Table 5.1: times of the calculation steps", grid});
  report.notes.push_back(
      "own: median over the scenes, grasps for all objects; the sum's median is no sum of medians; "
      "published: 2 GHz Core 2 Duo");
  report.csv = grid;
  return report;
}

// A scene of figures 5.8 and 5.9.
struct SceneTimes {
  int scene = 0, object_points = 0, table_points = 0;
  ByStep own;        // seconds by segmentation
  ByStep published;  // likewise
};

std::vector<SceneTimes> ScenesOf(const experiment::Stamp& stamp,
                                 const std::vector<Record>& records) {
  std::map<int, SceneTimes> scenes;
  for (const Record& record : records) {
    const auto data = nlohmann::json::parse(record.result.data, nullptr, false);
    if (!data.is_object() || !data.contains("scene")) continue;
    SceneTimes& one = scenes[data.at("scene")];
    one.scene = data.at("scene");
    one.object_points = data.at("object_points");
    one.table_points = data.at("table_points");
    for (const auto& [step, seconds] : record.result.seconds) {
      if (step == "segments") one.own[record.which.group] = seconds;
    }
  }
  const auto csv = ReferenceOf(stamp);
  std::vector<SceneTimes> list;
  for (auto& [number, one] : scenes) {
    const auto row = static_cast<std::size_t>(number - 1);
    if (csv && row < csv->rows()) {
      one.published = {{"region_growing", csv->Number(row, csv->Column("region_growing_s"))},
                       {"mesh", csv->Number(row, csv->Column("mesh_segmentation_s"))}};
    }
    list.push_back(one);
  }
  return list;
}

// The same numbers as dots over the scenes' object points: published in seconds, own in
// milliseconds.
std::string PictureOf(const std::vector<SceneTimes>& scenes,
                      const std::vector<std::string>& methods) {
  constexpr std::array<const char*, 3> kColors = {"#d62728", "#1f77b4", "#2ca02c"};
  std::vector<draw::Panel> panels(2);
  panels[0] = {"published, 2 GHz Core 2 Duo", "points of objects", "s", {}, {}, {}, false};
  panels[1] = {"own", "points of objects", "ms", {}, {}, {}, false};
  for (const bool own : {false, true}) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      draw::Series series;
      series.label = methods[m];
      series.color = kColors[m % kColors.size()];
      series.dots = true;
      for (const SceneTimes& one : scenes) {
        const ByStep& times = own ? one.own : one.published;
        const auto found = times.find(methods[m]);
        if (found == times.end()) continue;
        series.x.push_back(one.object_points);
        series.y.push_back(own ? 1e3 * found->second : found->second);
      }
      if (!series.x.empty()) panels[own ? 1 : 0].series.push_back(series);
    }
  }
  for (auto& panel : panels) {
    double high = 0.0;
    for (const auto& series : panel.series) {
      high = std::max(high, *std::max_element(series.y.begin(), series.y.end()));
    }
    panel.y_range = {0.0, 1.1 * std::max(high, 1e-3)};
  }
  return draw::PlotSvg(panels);
}

experiment::Report SegmentationsReport(const experiment::Stamp& stamp,
                                       const std::vector<Record>& records) {
  const auto scenes = ScenesOf(stamp, records);
  const auto methods = GroupsOf(records);
  Grid grid;
  grid.header = {"scene", "object points", "table points"};
  for (const std::string& method : methods) {
    grid.header.push_back(method + " [s]");
    grid.header.push_back("published [s]");
  }
  grid.left.assign(grid.header.size(), false);
  Grid csv = grid;
  csv.header = {"scene", "object_points", "table_points"};
  for (const std::string& method : methods) {
    csv.header.push_back(method + "_s");
    csv.header.push_back("published_" + method + "_s");
  }
  experiment::Report report;
  for (const SceneTimes& one : scenes) {
    std::vector<std::string> row = {fmt::format("{}", one.scene),
                                    fmt::format("{}", one.object_points),
                                    fmt::format("{}", one.table_points)};
    for (const std::string& method : methods) {
      const auto own = SumOf(one.own, {method});
      const auto published = SumOf(one.published, {method});
      row.push_back(Text(own, kDigits));
      row.push_back(Text(published, 3));
      if (!published) continue;
      report.published.push_back(
          FigureOf(fmt::format("scene {}, {}", one.scene, method), *published, own, own ? 1 : 0));
    }
    grid.rows.push_back(row);
    std::replace(row.begin(), row.end(), std::string("-"), std::string());
    csv.rows.push_back(row);
  }
  report.sections.push_back({"Figures 5.8 and 5.9: times of the segmentations", grid});
  report.notes.push_back(
      "own: the segmentation alone, without the normals that region growing asks for; median of "
      "the repeats; published: 2 GHz Core 2 Duo");
  report.csv = csv;
  report.files = {{"segmentation_times.csv", experiment::CsvOf(csv)},
                  {"segmentation_times.svg", PictureOf(scenes, methods)}};
  return report;
}

}  // namespace

experiment::Report ReportOf(const experiment::Stamp& stamp, const std::vector<Record>& records) {
  const std::string& timed = experiment::Need(stamp.data, kTimed);
  return timed == base::Word(Timed::kStages) ? StagesReport(stamp, records)
                                             : SegmentationsReport(stamp, records);
}

}  // namespace rangegrasp::times
