#pragma once

#include <cstddef>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// A profile as it stands in a file: heights in metres, still on the sensor's own x.
struct RawRow {
  std::size_t row = 0;    ///< from 1
  std::size_t line = 0;   ///< of the file
  std::size_t width = 0;  ///< numbers that it holds; 0: any
  std::optional<double> time_s = {};
  std::optional<double> position_m = {};  ///< of the encoder
  std::vector<double> x_m = {};           ///< empty: even; else as many as heights
  std::vector<float> height_m = {};       ///< NaN: no value
  std::string fault = {};                 ///< empty if whole
};

/// Empties the row and names it: "row 3 (line 4), column 2: 'two' is not a number".
void MarkDamaged(RawRow& row, const std::string& fault);

/// What is wrong with a row's width.
std::string WidthFault(std::size_t columns, int expected);

/// The height of a number of a file [m]; NaN if it means that there is none.
/// @throws base::InputError if it is out of range; the caller names the number.
float HeightOf(double number, const HeightScale& scale, const ProfileFileOptions& options);

/// Gives the rows of a text as they arrive, nullopt at its end. All have one width; where the
/// options do not state it, two of the first three whole rows do, or else the first. A damaged row
/// is returned with its fault. `in` must outlive it.
using RowSource = std::function<std::optional<RawRow>()>;
RowSource RowsOfText(std::istream& in, const ProfileFileOptions& options);

}  // namespace rangegrasp::seam
