#include "base/csv.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "base/words.h"

namespace rangegrasp::base {
namespace {

// Takes one record from the front of `rest`; line counts the line breaks in it.
std::vector<std::string> TakeRecord(std::string_view& rest, int& line, const std::string& name) {
  std::vector<std::string> cells(1);
  const int first_line = line;
  bool quoted = false;
  std::size_t i = 0;
  for (; i < rest.size(); ++i) {
    const char c = rest[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c != '"') {
        cells.back() += c;
      } else if (i + 1 < rest.size() && rest[i + 1] == '"') {
        cells.back() += rest[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"' && cells.back().empty()) {
      quoted = true;
    } else if (c == ',') {
      cells.emplace_back();
    } else if (c == '\n') {
      break;
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  if (quoted) {
    throw InputError(fmt::format("{}:{}: a quote is not closed", name, first_line));
  }
  rest.remove_prefix(std::min(i + 1, rest.size()));
  return cells;
}

}  // namespace

CsvTable CsvTable::Parse(std::string_view text, const std::string& name) {
  CsvTable table;
  table.name_ = name;
  int line = 1;
  while (!text.empty()) {
    const int at = line;
    auto cells = TakeRecord(text, line, name);
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (table.header_.empty()) {
      table.header_ = std::move(cells);
      continue;
    }
    if (cells.size() != table.header_.size()) {
      throw InputError(fmt::format("{}:{}: has {} cells; there must be {}: {}", name, at,
                                   cells.size(), table.header_.size(), Join(table.header_, ",")));
    }
    table.rows_.push_back({at, std::move(cells)});
  }
  if (table.header_.empty()) {
    throw InputError(name + ": is empty; a line that names the columns is needed");
  }
  return table;
}

CsvTable CsvTable::Read(const std::filesystem::path& file) {
  return Parse(ReadFile(file), file.string());
}

std::size_t CsvTable::Column(const std::string& name) const {
  return WordPosition(name, header_, name_ + ": column");
}

double CsvTable::Number(std::size_t row, std::size_t column) const {
  const auto value = NumberFrom<double>(Cell(row, column));
  if (!value || !std::isfinite(*value)) Fail(row, column, "must be a number");
  return *value;
}

std::optional<double> CsvTable::OptionalNumber(std::size_t row, std::size_t column) const {
  if (Cell(row, column).empty()) return std::nullopt;
  return Number(row, column);
}

void CsvTable::Fail(std::size_t row, std::size_t column, const std::string& what) const {
  throw InputError(fmt::format("{}:{}: column '{}': '{}' {}", name_, rows_[row].line,
                               header_[column], Cell(row, column), what));
}

std::string CsvCell(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string CsvLine(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? "," : "") + CsvCell(cells[i]);
  return line + "\n";
}

}  // namespace rangegrasp::base
