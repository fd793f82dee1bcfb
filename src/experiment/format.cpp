#include "experiment/format.h"

#include <nlohmann/json.hpp>

#include "base/number.h"

namespace rangegrasp::experiment {
namespace {

using nlohmann::ordered_json;

// A cell as JSON: a number where it is one, null where nothing was counted.
ordered_json CellJson(const std::string& cell) {
  if (cell == "-" || cell.empty()) return nullptr;
  const auto number = base::NumberFrom<double>(cell);
  return number ? ordered_json(*number) : ordered_json(cell);
}

ordered_json TableJson(const Section& section) {
  ordered_json rows = ordered_json::array();
  for (const auto& row : section.grid.rows) {
    ordered_json cells = ordered_json::array();
    for (const std::string& cell : row) cells.push_back(CellJson(cell));
    rows.push_back(cells);
  }
  return {{"title", section.title}, {"columns", section.grid.header}, {"rows", rows}};
}

std::string FormatJson(const Report& report, const Stamp& stamp) {
  ordered_json json;
  const auto name = stamp.identity.find("experiment");
  json["experiment"] = name == stamp.identity.end() ? "" : name->second;
  json["stamp"] = ordered_json::object();
  for (const auto* part : {&stamp.identity, &stamp.build}) {
    for (const auto& [key, value] : *part) json["stamp"][key] = value;
  }
  if (report.json.empty()) {
    json["tables"] = ordered_json::array();
    for (const Section& section : report.sections) json["tables"].push_back(TableJson(section));
  } else {
    json.update(ordered_json::parse(report.json));
  }
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string FormatCsv(const Report& report) {
  if (!report.csv.header.empty()) return CsvOf(report.csv);
  std::string text;
  for (const Section& section : report.sections) text += CsvOf(section.grid) + "\n";
  return text;
}

}  // namespace

std::string Format(const Report& report, const Stamp& stamp, TableFormat format) {
  if (format == TableFormat::kJson) return FormatJson(report, stamp);
  if (format == TableFormat::kCsv) return FormatCsv(report);
  const bool markdown = format == TableFormat::kMarkdown;
  const std::string gap = markdown ? "\n" : "";
  std::string text;
  for (const Section& section : report.sections) {
    if (!section.title.empty()) text += section.title + (markdown ? ":\n\n" : "\n\n");
    text += markdown ? MarkdownOf(section.grid) : TextOf(section.grid);
    if (!section.title.empty()) text += "\n";
  }
  for (const std::string& note : report.notes) text += gap + note + "\n";
  return text + gap + LineOf(stamp) + "\n";
}

}  // namespace rangegrasp::experiment
