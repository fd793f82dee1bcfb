#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// A profile as read from a file: heights in metres, at the sensor's own x.
struct RawRow {
  std::size_t row = 0;    ///< number, from 1
  std::size_t line = 0;   ///< line number in the file
  std::size_t width = 0;  ///< number of its values; 0: any
  std::optional<double> time_s = {};
  std::optional<double> position_m = {};  ///< encoder position
  std::vector<double> x_m = {};           ///< empty: evenly spaced; else one per height
  std::vector<float> height_m = {};       ///< NaN: no value
  bool open_end = false;   ///< the line ends with a separator: perhaps another height is missing
  std::string fault = {};  ///< empty if valid
};

/// Clears the row's values and sets its fault: "row 3 (line 4), column 2: 'two' is not a number".
void MarkDamaged(RawRow& row, const std::string& fault);

/// Error message for a row of the wrong width.
std::string WidthFault(std::size_t columns, int expected);

/// Converts a number in a file to a height [m]; NaN if it stands for a missing value.
/// @throws base::InputError if it is out of range; the caller names the number.
float HeightOf(double number, const HeightScale& scale, const ProfileFileOptions& options);

/// Removes and returns the first row, if there is one.
std::optional<RawRow> TakeFirst(std::deque<RawRow>& rows);

/// Returns the rows of a text as they arrive, and nullopt at its end. All rows have the same width:
/// that of the options or, if not given, of two of the first three valid rows or else of the first.
/// After a separator at the end of a line, a height is missing if the other rows have one more.
/// A damaged row is returned with its fault. `in` must outlive the source.
using RowSource = std::function<std::optional<RawRow>()>;
RowSource RowsOfText(std::istream& in, const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
