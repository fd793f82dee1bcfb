#pragma once

#include <optional>
#include <span>
#include <vector>

#include "seam/internal/raw_row.h"

namespace rangegrasp::seam {

/// Evenly spaced columns along a line's x.
struct EvenGrid {
  double first_m = 0.0;
  double pitch_m = 0.0;
  std::size_t columns = 0;

  double CenterX() const { return first_m + 0.5 * pitch_m * static_cast<double>(columns - 1); }
};

/// The grid that holds all points that have a height, with so many columns a metre; 0: with the
/// usual distance of neighbouring points. nullopt if no row has two points.
/// @throws base::InputError if it has more columns than a profile can have.
std::optional<EvenGrid> GridOf(std::span<const RawRow> rows, double columns_per_m);

/// A row's heights at the columns of a grid, linear between neighbouring points. Between points
/// that are further from each other than 1.5 times their usual distance there is nothing: a gap
/// stays a gap, and so does what was not measured.
std::vector<float> OnGrid(const RawRow& row, const EvenGrid& grid);

}  // namespace rangegrasp::seam
