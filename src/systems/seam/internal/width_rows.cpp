#include "seam/internal/width_rows.h"

#include <algorithm>
#include <vector>

namespace rangegrasp::seam {
namespace {

constexpr std::size_t kRowsOfWidth = 3;
// Damaged rows before them are not held back for ever.
constexpr std::size_t kMaxRowsHeld = 16;

}  // namespace

std::optional<RawRow> WidthRows::Next() {
  if (!settled_ && options_.columns == 0 && held_.empty()) FixWidth();
  if (held_.empty()) return rows_.Next();
  RawRow row = std::move(held_.front());
  held_.pop_front();
  return row;
}

void WidthRows::FixWidth() {
  std::vector<std::size_t> widths;
  while (!settled_ && held_.size() < kMaxRowsHeld) {
    auto row = rows_.Next();
    if (!row) break;
    held_.push_back(std::move(*row));
    if (!held_.back().fault.empty()) continue;
    const std::size_t width = held_.back().width;
    settled_ = width == 0 || std::ranges::find(widths, width) != widths.end();
    widths.push_back(width);
    if (settled_) options_.columns = static_cast<int>(width);
    if (widths.size() == kRowsOfWidth) break;
  }
  if (!settled_ && !widths.empty()) options_.columns = static_cast<int>(widths[0]);
  for (RawRow& row : held_) {
    const auto width = static_cast<std::size_t>(options_.columns);
    if (!row.fault.empty() || width == 0 || row.width == width) continue;
    MarkDamaged(row, WidthFault(row.width, options_.columns));
  }
}

}  // namespace rangegrasp::seam
