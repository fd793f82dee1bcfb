#include "experiment/grid.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/csv.h"
#include "base/words.h"
#include "experiment/statistics.h"

namespace rangegrasp::experiment {
namespace {

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
    for (const std::string& cell : row) text += " " + cell + " |";
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

std::string Fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

std::string PercentText(int k, int n, int digits) {
  return n == 0 ? "-" : Fixed(100.0 * k / n, digits);
}

std::string CountsText(const std::map<std::string, int>& counts) {
  std::vector<std::string> words;
  for (const auto& [word, count] : counts) words.push_back(fmt::format("{} {}", word, count));
  return base::Join(words);
}

std::string IntervalText(int k, int n) {
  if (n == 0) return "-";
  const auto [low, high] = WilsonInterval(k, n);
  return Fixed(low * 100.0, 0) + "-" + Fixed(high * 100.0, 0);
}

}  // namespace rangegrasp::experiment
