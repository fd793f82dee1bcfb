#pragma once

#include <map>
#include <string>
#include <vector>

namespace rangegrasp::experiment {

/// Cells that people read, as text (columns aligned), Markdown or CSV.
struct Grid {
  std::vector<std::string> header;
  std::vector<bool> left;  ///< columns of words; numbers stand to the right; as many as the header
  std::vector<std::vector<std::string>> rows;
  bool total = false;  ///< the last row is a total: a line stands above it
};

std::string TextOf(const Grid& grid);
std::string MarkdownOf(const Grid& grid);
/// Cells that hold a comma or a quote are quoted.
std::string CsvOf(const Grid& grid);

/// A number with so many digits after the point.
std::string Fixed(double value, int digits);
/// k of n in per cent; "-" for n = 0.
std::string PercentText(int k, int n, int digits);
/// "no_path 1, dropped 2"
std::string CountsText(const std::map<std::string, int>& counts);
/// "low-high" in whole per cent, of Wilson's 95 % interval of k of n; "-" for n = 0.
std::string IntervalText(int k, int n);

}  // namespace rangegrasp::experiment
