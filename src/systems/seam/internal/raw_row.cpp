#include "seam/internal/raw_row.h"

#include <fmt/format.h>

#include <string_view>

namespace rangegrasp::seam {

std::string Quoted(std::string_view text) {
  // Characters: enough for a number with all its digits.
  constexpr std::size_t kMaxShown = 24;
  std::string shown(text.substr(0, kMaxShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + shown + (text.size() > kMaxShown ? "..." : "") + "'";
}

std::string WidthFault(std::size_t columns, int expected) {
  return fmt::format("has {} columns instead of {}", columns, expected);
}

void MarkDamaged(RawRow& row, const std::string& fault) {
  RawRow named;
  named.row = row.row;
  named.line = row.line;
  named.fault = fmt::format("row {}{}{}{}", row.row,
                            row.line != row.row ? fmt::format(" (line {})", row.line) : "",
                            fault.starts_with("column") ? ", " : " ", fault);
  row = std::move(named);
}

}  // namespace rangegrasp::seam
