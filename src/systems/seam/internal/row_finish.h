#pragma once

#include <optional>
#include <span>

#include "seam/internal/even_grid.h"
#include "seam/internal/raw_row.h"
#include "seam/profile_io.h"

namespace rangegrasp::seam {

/// Makes profiles of rows, in their order: onto the even grid, with a time.
class RowFinish {
 public:
  explicit RowFinish(const ProfileFileOptions& options) : options_(options) {}

  /// The grid for rows like these, if they have x. @throws base::InputError as GridOf.
  void FixGrid(std::span<const RawRow> rows);
  const std::optional<EvenGrid>& grid() const { return grid_; }
  ProfileRow operator()(RawRow&& row);

 private:
  struct Stamp {
    double time_s = 0.0;
    std::optional<double> position_m;
  };
  Stamp StampOf(const RawRow& row) const;
  std::string StampFault(const Stamp& stamp) const;
  std::optional<double> GapBefore(const Stamp& stamp);

  ProfileFileOptions options_;
  std::optional<EvenGrid> grid_;
  std::optional<Stamp> last_;  // of the last whole row
  double max_gap_s_ = 0.0;     // 0: not known yet
};

}  // namespace rangegrasp::seam
