#include "recognition/task/recognition_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/quantile.h"
#include "base/units.h"

namespace rangegrasp::recognition_task {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;

/// What is counted of a row's scenes.
struct Row {
  std::string title;
  int scenes = 0, found = 0, wrong_object = 0;
  std::map<std::string, int> otherwise;
  std::vector<double> distance_mm, angle_deg;
};

/// What is counted of all finds of all scenes.
struct Finds {
  int all = 0, wrong = 0, others = 0, others_near = 0;
};

void Add(const experiment::Record& record, Row& row, Finds& finds) {
  ++row.scenes;
  const std::string& outcome = record.result.outcome;
  row.found += outcome == "found";
  row.wrong_object += outcome == "wrong_object";
  if (outcome != "found") ++row.otherwise[outcome];
  const auto data = nlohmann::json::parse(record.result.data);
  if (!data.contains("finds")) return;
  for (const auto& find : data.at("finds")) {
    ++finds.all;
    finds.wrong += !find.at("named_right").get<bool>();
    if (!find.at("named_right").get<bool>()) continue;
    if (find.at("is_target").get<bool>()) {
      row.distance_mm.push_back(find.at("distance_m").get<double>() * base::kMmPerM);
      row.angle_deg.push_back(find.at("angle_rad").get<double>() / base::kDeg);
    } else {
      ++finds.others;
      finds.others_near += find.at("near").get<bool>();
    }
  }
}

std::string Median(const std::vector<double>& values, int digits) {
  return values.empty() ? "-" : Fixed(base::MedianOf(values), digits);
}

std::vector<std::string> Cells(const Row& row) {
  return {row.title,
          fmt::format("{}", row.scenes),
          experiment::PercentText(row.found, row.scenes, 1),
          IntervalText(row.found, row.scenes),
          fmt::format("{}", row.wrong_object),
          Median(row.distance_mm, 1),
          Median(row.angle_deg, 1),
          experiment::CountsText(row.otherwise)};
}

void AddTo(const Row& row, Row& all) {
  all.scenes += row.scenes;
  all.found += row.found;
  all.wrong_object += row.wrong_object;
  for (const auto& [word, count] : row.otherwise) all.otherwise[word] += count;
  all.distance_mm.insert(all.distance_mm.end(), row.distance_mm.begin(), row.distance_mm.end());
  all.angle_deg.insert(all.angle_deg.end(), row.angle_deg.begin(), row.angle_deg.end());
}

std::string TimesNote(const std::vector<experiment::Record>& records) {
  std::map<std::string, std::vector<double>> each;
  for (const auto& record : records) {
    for (const auto& [stage, seconds] : record.result.seconds) each[stage].push_back(seconds);
  }
  std::string text = "median seconds of a scene:";
  for (const auto& [stage, seconds] : each) {
    text += fmt::format(" {} {}", stage, Fixed(base::MedianOf(seconds), 2));
  }
  return text;
}

}  // namespace

experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  std::vector<std::string> order;
  std::map<std::string, Row> rows;
  Finds finds;
  for (const auto& record : records) {
    const std::string& object = record.which.group;
    if (!rows.contains(object)) {
      order.push_back(object);
      rows[object].title = experiment::TitleOf(stamp, object);
    }
    Add(record, rows[object], finds);
  }
  Grid grid;
  grid.header = {"object",       "scenes",          "found %",          "95 %",
                 "wrong object", "off mm (median)", "off deg (median)", "otherwise"};
  grid.left.assign(grid.header.size(), false);
  grid.left.front() = grid.left.back() = true;
  Row all;
  all.title = "All";
  for (const std::string& object : order) {
    grid.rows.push_back(Cells(rows[object]));
    AddTo(rows[object], all);
  }
  grid.rows.push_back(Cells(all));
  grid.total = true;
  experiment::Report report;
  report.sections.push_back({"Known objects: the scene's target", grid});
  report.csv = grid;
  report.notes.push_back(fmt::format(
      "of {} objects that were named in all scenes {} were another one ({} %, 95 %: {})", finds.all,
      finds.wrong, experiment::PercentText(finds.wrong, finds.all, 1),
      IntervalText(finds.wrong, finds.all)));
  if (finds.others > 0) {
    report.notes.push_back(fmt::format(
        "of {} others that were named right {} in their pose ({} %)", finds.others,
        finds.others_near, experiment::PercentText(finds.others_near, finds.others, 1)));
  }
  report.notes.push_back(TimesNote(records));
  return report;
}

}  // namespace rangegrasp::recognition_task
