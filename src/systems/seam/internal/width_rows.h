#pragma once

#include <deque>
#include <istream>
#include <optional>

#include "seam/internal/text_rows.h"

namespace rangegrasp::seam {

/// Rows of a text of one width. Where the options do not tell it, two of the first three whole rows
/// do, or else the first.
class WidthRows {
 public:
  WidthRows(std::istream& in, const ProfileFileOptions& options)
      : options_(options), rows_(in, options_) {}
  WidthRows(const WidthRows&) = delete;
  WidthRows& operator=(const WidthRows&) = delete;
  std::optional<RawRow> Next();

 private:
  void FixWidth();

  ProfileFileOptions options_;
  TextRows rows_;
  std::deque<RawRow> held_;  // read while the width was unknown
  bool settled_ = false;
};

}  // namespace rangegrasp::seam
