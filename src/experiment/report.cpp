#include "experiment/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

using nlohmann::ordered_json;

std::vector<std::size_t> Widths(const Grid& grid) {
  std::vector<std::size_t> widths;
  for (const std::string& cell : grid.header) widths.push_back(cell.size());
  for (const auto& row : grid.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  return widths;
}

std::string TextLine(const Grid& grid, const std::vector<std::string>& row,
                     const std::vector<std::size_t>& widths) {
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::string pad(widths[i] - row[i].size(), ' ');
    line += (i > 0 ? "  " : "") + (grid.left[i] ? row[i] + pad : pad + row[i]);
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

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

// Text as it is, nothing for null, a list as JSON.
std::string CellOf(const ordered_json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void Flatten(const ordered_json& value, const std::string& name,
             std::vector<std::pair<std::string, std::string>>& cells) {
  if (!value.is_object()) {
    cells.emplace_back(name, CellOf(value));
    return;
  }
  for (const auto& [key, inner] : value.items()) {
    Flatten(inner, name.empty() ? key : name + "." + key, cells);
  }
}

}  // namespace

std::string TextOf(const Grid& grid) {
  const auto widths = Widths(grid);
  std::size_t length = 2 * (widths.size() - 1);
  for (const std::size_t width : widths) length += width;
  const std::string rule = std::string(length, '-') + "\n";
  std::string text = TextLine(grid, grid.header, widths) + rule;
  for (std::size_t r = 0; r < grid.rows.size(); ++r) {
    if (grid.total && r + 1 == grid.rows.size()) text += rule;
    text += TextLine(grid, grid.rows[r], widths);
  }
  return text;
}

std::string MarkdownOf(const Grid& grid) {
  const auto line = [](const std::vector<std::string>& row) {
    std::string text = "|";
    for (const std::string& cell : row) {
      text += " " + base::Join(base::Split(cell, '|'), "\\|") + " |";
    }
    return text + "\n";
  };
  std::string text = line(grid.header) + "|";
  for (const bool left : grid.left) text += left ? " --- |" : " ---: |";
  text += "\n";
  for (const auto& row : grid.rows) text += line(row);
  return text;
}

std::string CsvOf(const Grid& grid) {
  std::string text = base::CsvLine(grid.header);
  for (const auto& row : grid.rows) text += base::CsvLine(row);
  return text;
}

std::optional<base::CsvTable> ReferenceOf(const Stamp& stamp) {
  const auto text = stamp.data.find(kReferenceKey);
  if (text == stamp.data.end()) return std::nullopt;
  return base::CsvTable::Parse(text->second, "reference table");
}

std::string Fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

std::string PercentText(int k, int n, int digits) {
  return n == 0 ? "-" : Fixed(100.0 * k / n, digits);
}

std::string CountsText(const std::map<std::string, int>& counts) {
  std::vector<std::string> words;
  for (const auto& [word, count] : counts) words.push_back(fmt::format("{} {}", word, count));
  return base::Join(words);
}

std::string IntervalText(const std::optional<std::pair<double, double>>& interval) {
  if (!interval) return "-";
  return Fixed(interval->first * 100.0, 0) + "-" + Fixed(interval->second * 100.0, 0);
}

std::string IntervalText(int k, int n) { return n == 0 ? "-" : IntervalText(WilsonInterval(k, n)); }

Grid FlatGridOf(const std::vector<Record>& records) {
  Grid grid;
  std::unordered_map<std::string, std::size_t> column_of;
  for (const Record& record : records) {
    std::vector<std::pair<std::string, std::string>> cells;
    Flatten(ordered_json::parse(ToJson(record)), "", cells);
    auto& row = grid.rows.emplace_back(grid.header.size());
    for (auto& [name, cell] : cells) {
      const auto [column, fresh] = column_of.try_emplace(name, grid.header.size());
      if (fresh) {
        grid.header.push_back(name);
        row.emplace_back();
      }
      row[column->second] = std::move(cell);
    }
  }
  for (auto& row : grid.rows) row.resize(grid.header.size());
  grid.left.assign(grid.header.size(), true);
  return grid;
}

namespace {

std::string FormatJson(const Report& report, const Stamp& stamp) {
  ordered_json json;
  json["experiment"] = ValueOr(stamp.identity, "experiment", "");
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

Chart::Value PercentOf(const Count& count) {
  if (count.n == 0) return {};
  const auto [low, high] = WilsonInterval(count.k, count.n);
  return {100.0 * count.k / count.n, std::pair(100.0 * low, 100.0 * high),
          fmt::format("{} of {}", count.k, count.n)};
}

}  // namespace rangegrasp::experiment
