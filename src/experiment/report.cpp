#include "experiment/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

using nlohmann::ordered_json;

std::size_t Longest(const std::vector<std::string>& lines) {
  std::size_t length = 0;
  for (const std::string& line : lines) length = std::max(length, line.size());
  return length;
}

// Breaks a title into lines no longer than the column's values or its own longest word.
std::vector<std::string> TitleLines(const std::string& title, std::size_t value_width) {
  const auto words = base::Split(title, ' ');
  const std::size_t width = std::max(value_width, Longest(words));
  std::vector<std::string> lines = {words[0]};
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (lines.back().size() + 1 + words[i].size() > width) {
      lines.push_back(words[i]);
    } else {
      lines.back() += " " + words[i];
    }
  }
  return lines;
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

// A cell as JSON: a number if it is one, null if nothing was counted.
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

// A JSON value as a cell: text unchanged, nothing for null, a list as JSON.
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
  std::vector<std::size_t> widths(grid.header.size(), 0);
  for (const auto& row : grid.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::vector<std::vector<std::string>> titles;
  std::size_t height = 0, length = 2 * (widths.size() - 1);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    titles.push_back(TitleLines(grid.header[i], widths[i]));
    height = std::max(height, titles[i].size());
    const std::size_t title_width = Longest(titles[i]);
    widths[i] = std::max(widths[i], title_width);
    // Words in the last column may be long and extend beyond the rule.
    length += i + 1 == widths.size() && grid.left[i] ? title_width : widths[i];
  }
  std::string text;
  for (std::size_t line = 0; line < height; ++line) {
    std::vector<std::string> row;
    for (const auto& title : titles) {
      const std::size_t above = height - title.size();  // titles are aligned at the bottom
      row.push_back(line < above ? "" : title[line - above]);
    }
    text += TextLine(grid, row, widths);
  }
  const std::string rule = std::string(length, '-') + "\n";
  text += rule;
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

std::string PublishedText(const std::filesystem::path& file) {
  std::string text = base::ReadFile(file);
  if (base::CsvTable::Parse(text, file.string()).rows() > 0) return text;
  throw base::InputError(file.string() + ": has no row below its header line");
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
