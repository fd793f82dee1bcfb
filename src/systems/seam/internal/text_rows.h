#pragma once

#include <deque>
#include <istream>
#include <optional>
#include <string_view>
#include <vector>

#include "seam/internal/raw_row.h"
#include "seam/internal/text_lines.h"
#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// Rows of a text as they arrive. A damaged row is returned with its fault.
class TextRows {
 public:
  /// The options must outlive it; `options.columns` may be set meanwhile.
  TextRows(std::istream& in, const ProfileFileOptions& options)
      : lines_(in, options.text), options_(options) {}
  std::optional<RawRow> Next();

 private:
  // Columns from 0; below 0: there is none.
  struct Columns {
    int time = -1, encoder = -1, axis = -1, profile = -1, x = -1, z = -1, first = 0;
  };
  using Fields = std::vector<std::string_view>;

  std::optional<RawRow> NextOfLines();
  std::optional<RawRow> NextOfPoints();
  std::optional<RawRow> NextOfColumns();
  void FindColumns();
  int Find(const std::string& name, const char* key) const;
  void ReadHeaderX();
  Fields ValuesOf(const TextLine& line) const;
  std::string Parse(const TextLine& line, RawRow& row, bool& is_profile);
  std::string ParseStamps(const Fields& fields, RawRow& row) const;
  std::string ParseHeights(const Fields& fields, RawRow& row) const;
  std::string ParsePairs(const Fields& fields, RawRow& row) const;
  std::string ParsePoint(const Fields& fields, RawRow& row) const;
  std::string ParseXRow(const Fields& fields);
  std::string ParseNumber(const Fields& fields, int field, double& number) const;
  std::string ParseHeight(const Fields& fields, int field, float& height_m) const;
  void ReadColumns();

  TextLines lines_;
  const ProfileFileOptions& options_;
  std::optional<Columns> columns_;
  std::size_t row_ = 0;
  std::vector<double> axis_x_m_;  // of the last row of X
  std::vector<double> header_x_m_;
  std::optional<TextLine> begun_;  // kPoints: the first line of the next profile
  std::deque<RawRow> transposed_;  // kColumns
  bool transposed_all_ = false;
};

}  // namespace rangegrasp::seam
