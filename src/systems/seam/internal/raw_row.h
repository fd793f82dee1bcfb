#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::seam {

/// A profile as it stands in a file: heights in metres, still on the sensor's own x.
struct RawRow {
  std::size_t row = 0;    ///< from 1
  std::size_t line = 0;   ///< of the file
  std::size_t width = 0;  ///< numbers that it holds; 0: as many as it likes
  std::optional<double> time_s;
  std::optional<double> position_m;  ///< of the encoder
  std::vector<double> x_m;           ///< empty: even; else as many as heights
  std::vector<float> height_m;       ///< NaN: no value
  std::string fault;                 ///< empty if whole
};

/// Empties the row and names it: "row 3 (line 4), column 2: 'two' is not a number".
void MarkDamaged(RawRow& row, const std::string& fault);

/// What is wrong with a row's width.
std::string WidthFault(std::size_t columns, int expected);

/// A piece of a file for a message: short, and nothing that a terminal would obey.
std::string Quoted(std::string_view text);

}  // namespace rangegrasp::seam
