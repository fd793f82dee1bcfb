#include "seam/internal/row_finish.h"

#include <fmt/format.h>

#include "base/units.h"

namespace rangegrasp::seam {
namespace {

// Without an option: so many times the first two rows' distance in time is an outage, as so many
// unusable profiles one after the other are for the monitor.
constexpr double kGapRows = 10.0;

}  // namespace

void RowFinish::FixGrid(std::span<const RawRow> rows) {
  if (!grid_) grid_ = GridOf(rows, options_.columns_per_m);
}

RowFinish::Stamp RowFinish::StampOf(const RawRow& row) const {
  Stamp stamp{static_cast<double>(row.row - 1) / options_.rate_hz, row.position_m};
  if (row.position_m) stamp.time_s = *row.position_m / options_.feed_m_per_s;
  if (row.time_s) stamp.time_s = *row.time_s;
  return stamp;
}

std::string RowFinish::StampFault(const Stamp& stamp) const {
  if (!last_) return {};
  if (stamp.position_m && last_->position_m && *stamp.position_m < *last_->position_m) {
    return fmt::format(
        "is at {:.6g} mm of the path, the row before at {:.6g} mm; the encoder must not go back",
        *stamp.position_m * base::kMmPerM, *last_->position_m * base::kMmPerM);
  }
  if (stamp.time_s < last_->time_s) {
    return fmt::format("is of {:.9g} s, the row before of {:.9g} s; time must not go back",
                       stamp.time_s, last_->time_s);
  }
  return {};
}

std::optional<double> RowFinish::GapBefore(const Stamp& stamp) {
  if (!last_) return std::nullopt;
  const double passed_s = stamp.time_s - last_->time_s;
  if (max_gap_s_ == 0.0) {
    max_gap_s_ = options_.max_gap_s > 0.0 ? options_.max_gap_s : kGapRows * passed_s;
  }
  if (max_gap_s_ == 0.0 || passed_s <= max_gap_s_) return std::nullopt;
  return passed_s;
}

ProfileRow RowFinish::operator()(RawRow&& row) {
  ProfileRow made{.row = row.row,
                  .line = row.line,
                  .profile = {},
                  .fault = row.fault,
                  .position_m = row.position_m,
                  .gap_s = {}};
  if (!made.fault.empty()) return made;
  const Stamp stamp = StampOf(row);
  std::string fault = StampFault(stamp);
  if (fault.empty() && !row.x_m.empty() && !grid_) fault = "has no two points with a height";
  if (!fault.empty()) {
    MarkDamaged(row, fault);
    made.fault = row.fault;
    return made;
  }
  if (row.time_s || row.position_m) made.gap_s = GapBefore(stamp);
  last_ = stamp;
  made.profile.time_s = stamp.time_s;
  made.profile.height_m = grid_ ? OnGrid(row, *grid_) : std::move(row.height_m);
  return made;
}

}  // namespace rangegrasp::seam
