#include <nlohmann/json.hpp>
#include <sstream>

#include "report/grid.h"
#include "report/statistics.h"
#include "report/table.h"

namespace rangegrasp::report {
namespace {

using Cells = std::vector<std::string>;

std::string Percent(const std::optional<double>& rate) {
  return rate ? Fixed(*rate * 100.0, 2) : "-";
}

// The failures of a row, e.g. "no_path 1, dropped 2".
std::string Failures(const Row& row) {
  std::string text;
  for (const auto& [outcome, count] : row.outcomes) {
    if (outcome == "delivered") continue;
    text += (text.empty() ? "" : ", ") + outcome + " " + std::to_string(count);
  }
  return text;
}

const Cells kHeader = {"no.",       "object",     "trials", "detection %", "95 %",
                       "published", "grasping %", "95 %",   "published",   "failures"};

Cells RowCells(const Row& row, const std::string& number) {
  return {number,
          row.title.empty() ? row.object : row.title,
          std::to_string(row.trials),
          Percent(row.detection_rate),
          IntervalText(row.detected, row.trials),
          Percent(row.published_detection_rate),
          Percent(row.grasp_rate),
          IntervalText(row.delivered, row.detected),
          Percent(row.published_grasp_rate),
          Failures(row)};
}

Grid GridOf(const Table& table) {
  Grid grid;
  grid.header = kHeader;
  grid.left.assign(kHeader.size(), false);
  grid.left[1] = grid.left.back() = true;
  grid.total = true;
  int number = 0;
  for (const Row& row : table.rows) grid.rows.push_back(RowCells(row, std::to_string(++number)));
  grid.rows.push_back(RowCells(table.overall, ""));
  return grid;
}

std::string StampLine(const Table& table) {
  const auto get = [&](const char* key) {
    const auto it = table.stamp.find(key);
    return it == table.stamp.end() ? std::string("?") : it->second;
  };
  return get("experiment") + ": rangegrasp " + get("version") + " (" + get("commit") +
         "), experiment " + get("experiment_hash") + ", scene " + get("scene_hash") + ", seed " +
         get("seed") + ", " + std::to_string(table.overall.trials) + " trials, MuJoCo " +
         get("mujoco");
}

std::string PooledLine(const Table& table) {
  return "pooled: detection " + Percent(table.pooled_detection_rate) + " % [" +
         IntervalText(table.overall.detected, table.overall.trials) + "], grasping " +
         Percent(table.pooled_grasp_rate) + " % [" +
         IntervalText(table.overall.delivered, table.overall.detected) + "]";
}

std::string TimesLine(const Table& table) {
  std::string line = "seconds, median (95 %):";
  for (const StageTime& time : table.stage_seconds) {
    if (time.stage.find(':') != std::string::npos) continue;  // steps within a stage: JSON only
    line += " " + time.stage + " " + Fixed(time.median_s, 3) + " (" + Fixed(time.p95_s, 3) + ")";
  }
  return line;
}

std::string FormatText(const Table& table) {
  return TextOf(GridOf(table)) + PooledLine(table) + "\n" + TimesLine(table) + "\n" +
         StampLine(table) + "\n";
}

std::string FormatMarkdown(const Table& table) {
  return MarkdownOf(GridOf(table)) + "\n" + PooledLine(table) + "\n\n" + StampLine(table) + "\n";
}

std::string FormatCsv(const Table& table) {
  std::ostringstream out;
  out << "object,title,trials,detected,delivered,detection_rate,grasp_rate,published_detection_"
         "rate,"
         "published_grasp_rate\n";
  const auto cell = [](const std::optional<double>& rate) {
    return rate ? Fixed(*rate, 4) : std::string();
  };
  const auto line = [&](const Row& row) {
    out << row.object << ",\"" << row.title << "\"," << row.trials << "," << row.detected << ","
        << row.delivered << "," << cell(row.detection_rate) << "," << cell(row.grasp_rate) << ","
        << cell(row.published_detection_rate) << "," << cell(row.published_grasp_rate) << "\n";
  };
  for (const Row& row : table.rows) line(row);
  line(table.overall);
  return out.str();
}

nlohmann::ordered_json Json(const std::optional<double>& rate) {
  return rate ? nlohmann::ordered_json(*rate) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json IntervalJson(int k, int n) {
  if (n == 0) return nullptr;
  const auto [low, high] = WilsonInterval(k, n);
  return {low, high};
}

nlohmann::ordered_json RowJson(const Row& row) {
  return {{"object", row.object},
          {"title", row.title},
          {"trials", row.trials},
          {"detected", row.detected},
          {"delivered", row.delivered},
          {"detection_rate", Json(row.detection_rate)},
          {"detection_interval", IntervalJson(row.detected, row.trials)},
          {"grasp_rate", Json(row.grasp_rate)},
          {"grasp_interval", IntervalJson(row.delivered, row.detected)},
          {"published_detection_rate", Json(row.published_detection_rate)},
          {"published_grasp_rate", Json(row.published_grasp_rate)},
          {"outcomes", row.outcomes}};
}

std::string FormatJson(const Table& table) {
  nlohmann::ordered_json json;
  const auto name = table.stamp.find("experiment");
  json["experiment"] = name == table.stamp.end() ? "" : name->second;
  auto stamp = table.stamp;
  stamp.erase("reference");
  json["stamp"] = stamp;
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : table.rows) json["rows"].push_back(RowJson(row));
  json["overall"] = RowJson(table.overall);
  json["overall"]["pooled_detection_rate"] = Json(table.pooled_detection_rate);
  json["overall"]["pooled_grasp_rate"] = Json(table.pooled_grasp_rate);
  json["audit_worst"] = table.audit_worst;
  json["stage_seconds"] = nlohmann::ordered_json::object();
  for (const StageTime& time : table.stage_seconds) {
    json["stage_seconds"][time.stage] = {{"median", time.median_s}, {"p95", time.p95_s}};
  }
  return json.dump(2) + "\n";
}

}  // namespace

std::string Format(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kText:
      return FormatText(table);
    case TableFormat::kMarkdown:
      return FormatMarkdown(table);
    case TableFormat::kCsv:
      return FormatCsv(table);
    case TableFormat::kJson:
      return FormatJson(table);
  }
  return "";
}

}  // namespace rangegrasp::report
