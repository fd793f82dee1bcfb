#include "seam/internal/text_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/number.h"
#include "base/words.h"
#include "seam/internal/height.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// A line of a sensor has fewer; without a bound a text that no profile ends in would fill the
// memory.
constexpr std::size_t kMaxPoints = 65536;

bool IsDamaged(const std::string& fault) { return !fault.empty(); }

}  // namespace

std::optional<RawRow> TextRows::Next() {
  switch (options_.text.layout) {
    case TextLayout::kPoints:
      return NextOfPoints();
    case TextLayout::kColumns:
      return NextOfColumns();
    case TextLayout::kRows:
    case TextLayout::kPairs:
      break;
  }
  return NextOfLines();
}

// ---- which column is what ----

int TextRows::Find(const std::string& name, const char* key) const {
  if (name.empty()) return -1;
  if (const auto number = base::NumberFrom<int>(name)) {
    if (*number >= 1) return *number - 1;
  }
  const auto& header = lines_.header();
  const auto found = std::ranges::find(header, name);
  if (found != header.end()) return static_cast<int>(found - header.begin());
  throw InputError(
      fmt::format("{}: {} is neither a column's number, from 1, nor in the header, which {}", key,
                  Quoted(name), header.empty() ? "is missing" : "has " + base::Join(header)));
}

void TextRows::FindColumns() {
  if (columns_) return;
  const TextFormat& text = options_.text;
  Columns columns;
  columns.time = Find(text.time_column, "time_column");
  columns.encoder = Find(text.encoder_column, "encoder_column");
  columns.axis = Find(text.axis_column, "axis_column");
  columns.profile = Find(text.profile_column, "profile_column");
  columns.first = std::max({columns.time, columns.encoder, columns.axis, columns.profile, -1}) + 1;
  if (!text.first_column.empty()) columns.first = Find(text.first_column, "first_column");
  columns.x = text.x_column.empty() ? columns.first : Find(text.x_column, "x_column");
  columns.z = text.z_column.empty() ? columns.x + 1 : Find(text.z_column, "z_column");
  columns_ = columns;
  if (text.x_in_header) ReadHeaderX();
}

void TextRows::ReadHeaderX() {
  const auto& header = lines_.header();
  if (header.empty()) throw InputError("x_in_header: there is no header (header_lines, header)");
  const Fields fields(header.begin(), header.end());
  header_x_m_.clear();
  for (int i = columns_->first; i < static_cast<int>(fields.size()); ++i) {
    double x = 0.0;
    if (fields[static_cast<std::size_t>(i)].empty() && i + 1 == static_cast<int>(fields.size()))
      break;
    const std::string fault = ParseNumber(fields, i, x);
    if (!fault.empty()) throw InputError("header, " + fault);
    header_x_m_.push_back(x * options_.text.scale.unit_m);
  }
}

// ---- fields ----

// Without the nothing behind a separator at the line's end, which begins no further field.
TextRows::Fields TextRows::ValuesOf(const TextLine& line) const {
  Fields fields = FieldsOf(line.text, options_.text);
  const auto expected =
      static_cast<std::size_t>(options_.columns) + static_cast<std::size_t>(columns_->first);
  if (fields.size() > 1 && fields.back().empty() &&
      (options_.columns == 0 || fields.size() == expected + 1)) {
    fields.pop_back();
  }
  return fields;
}

// NaN where there is no value.
std::string TextRows::ParseNumber(const Fields& fields, int field, double& number) const {
  if (field >= static_cast<int>(fields.size())) {
    return fmt::format("has {} columns; column {} is asked for", fields.size(), field + 1);
  }
  const std::string_view shown = fields[static_cast<std::size_t>(field)];
  number = kNoNumber;
  if (IsNoValue(shown)) return {};
  const auto parsed = NumberOf(shown, options_.text.decimal_comma);
  if (parsed) {
    number = *parsed;
    return {};
  }
  std::string fault = fmt::format("column {}: {} is not a number; no value is nan, - or nothing",
                                  field + 1, Quoted(shown));
  const bool comma = shown.find(',') != std::string_view::npos;
  if (comma && !options_.text.decimal_comma) fault += "; a decimal comma: decimal_comma";
  if (row_ == 0) fault += "; a header: header_lines";
  return fault;
}

std::string TextRows::ParseHeight(const Fields& fields, int field, float& height_m) const {
  double number = 0.0;
  std::string fault = ParseNumber(fields, field, number);
  if (IsDamaged(fault)) return fault;
  height_m = HeightOf(options_, options_.text.scale)(number, fault);
  if (!IsDamaged(fault)) return fault;
  return fmt::format("column {}: {} {}", field + 1, Quoted(fields[static_cast<std::size_t>(field)]),
                     fault);
}

std::string TextRows::ParseStamps(const Fields& fields, RawRow& row) const {
  const auto parse = [&](int column, double unit, std::optional<double>& value) -> std::string {
    if (column < 0) return {};
    double number = 0.0;
    std::string fault = ParseNumber(fields, column, number);
    if (fault.empty() && std::isnan(number)) {
      fault =
          fmt::format("column {}: there is no number; time and encoder must have one", column + 1);
    }
    if (fault.empty()) value = number * unit;
    return fault;
  };
  std::string fault = parse(columns_->time, options_.time_unit_s, row.time_s);
  return IsDamaged(fault) ? fault : parse(columns_->encoder, options_.encoder_m, row.position_m);
}

std::string TextRows::ParseHeights(const Fields& fields, RawRow& row) const {
  row.height_m.assign(row.width, 0.0F);
  for (std::size_t i = 0; i < row.width; ++i) {
    std::string fault = ParseHeight(fields, columns_->first + static_cast<int>(i), row.height_m[i]);
    if (IsDamaged(fault)) return fault;
  }
  row.x_m = columns_->axis >= 0 && !axis_x_m_.empty() ? axis_x_m_ : header_x_m_;
  if (!row.x_m.empty() && row.x_m.size() != row.width) {
    return fmt::format("has {} heights and {} x", row.width, row.x_m.size());
  }
  return {};
}

std::string TextRows::ParsePairs(const Fields& fields, RawRow& row) const {
  if (row.width % 2 != 0) {
    return fmt::format("has {} columns; pairs of x and height are an even number", row.width);
  }
  for (std::size_t i = 0; i < row.width; i += 2) {
    double x = 0.0;
    const int field = columns_->first + static_cast<int>(i);
    std::string fault = ParseNumber(fields, field, x);
    row.height_m.push_back(0.0F);
    if (fault.empty()) fault = ParseHeight(fields, field + 1, row.height_m.back());
    if (IsDamaged(fault)) return fault;
    row.x_m.push_back(x * options_.text.scale.unit_m);
  }
  return {};
}

std::string TextRows::ParsePoint(const Fields& fields, RawRow& row) const {
  double x = 0.0;
  float height = 0.0F;
  std::string fault = ParseNumber(fields, columns_->x, x);
  if (fault.empty()) fault = ParseHeight(fields, columns_->z, height);
  row.x_m.push_back(x * options_.text.scale.unit_m);
  row.height_m.push_back(height);
  return fault;
}

std::string TextRows::ParseXRow(const Fields& fields) {
  axis_x_m_.clear();
  for (int i = columns_->first; i < static_cast<int>(fields.size()); ++i) {
    double x = 0.0;
    std::string fault = ParseNumber(fields, i, x);
    if (IsDamaged(fault)) return fault;
    axis_x_m_.push_back(x * options_.text.scale.unit_m);
  }
  return {};
}

// ---- a line is a profile ----

std::string TextRows::Parse(const TextLine& line, RawRow& row, bool& is_profile) {
  is_profile = true;
  if (line.too_long) return "is longer than a profile can be";
  const Fields fields = ValuesOf(line);
  if (columns_->axis >= 0) {
    if (columns_->axis >= static_cast<int>(fields.size())) {
      return fmt::format("has {} columns; axis_column is {}", fields.size(), columns_->axis + 1);
    }
    const std::string_view axis = fields[static_cast<std::size_t>(columns_->axis)];
    is_profile = axis == "Z";
    if (axis == "X") return ParseXRow(fields);
    if (!is_profile) return {};
  }
  const auto first = static_cast<std::size_t>(columns_->first);
  row.width = fields.size() - std::min(first, fields.size());
  if (row.width == 0) return fmt::format("has {} columns and no height", fields.size());
  if (options_.columns != 0 && row.width != static_cast<std::size_t>(options_.columns)) {
    return WidthFault(row.width, options_.columns);
  }
  std::string fault = ParseStamps(fields, row);
  if (IsDamaged(fault)) return fault;
  const bool pairs = options_.text.layout == TextLayout::kPairs;
  return pairs ? ParsePairs(fields, row) : ParseHeights(fields, row);
}

std::optional<RawRow> TextRows::NextOfLines() {
  while (const auto line = lines_.Next()) {
    if (line->text.empty()) continue;
    FindColumns();
    RawRow row;
    row.line = line->number;
    bool is_profile = true;
    const std::string fault = Parse(*line, row, is_profile);
    if (fault.empty() && !is_profile) continue;
    row.row = ++row_;
    if (IsDamaged(fault)) MarkDamaged(row, fault);
    return row;
  }
  return std::nullopt;
}

// ---- a line is a point ----

std::optional<RawRow> TextRows::NextOfPoints() {
  RawRow row;
  std::optional<std::string> profile;
  std::string fault;
  while (auto line = begun_ ? begun_ : lines_.Next()) {
    begun_.reset();
    if (line->text.empty() && row.line == 0) continue;
    if (line->text.empty()) break;
    FindColumns();
    const Fields fields = FieldsOf(line->text, options_.text);
    const auto named = static_cast<std::size_t>(std::max(columns_->profile, 0));
    if (columns_->profile >= 0 && named < fields.size()) {
      if (profile && *profile != fields[named]) {
        begun_ = std::move(line);
        break;
      }
      profile = fields[named];
    }
    if (row.line == 0) {
      row.row = row_ + 1;
      row.line = line->number;
      fault = ParseStamps(fields, row);
    }
    if (IsDamaged(fault)) continue;
    if (row.x_m.size() == kMaxPoints) {
      fault = fmt::format(
          "has more than {} points; an empty line or another number in profile_column ends a "
          "profile",
          kMaxPoints);
      break;
    }
    fault = line->too_long ? "is longer than a point can be" : ParsePoint(fields, row);
    if (IsDamaged(fault)) row.line = line->number;
  }
  if (row.line == 0) return std::nullopt;
  ++row_;
  if (IsDamaged(fault)) MarkDamaged(row, fault);
  return row;
}

// ---- a column is a profile ----

std::optional<RawRow> TextRows::NextOfColumns() {
  if (!transposed_all_) ReadColumns();
  transposed_all_ = true;
  if (transposed_.empty()) return std::nullopt;
  RawRow row = std::move(transposed_.front());
  transposed_.pop_front();
  return row;
}

void TextRows::ReadColumns() {
  std::size_t width = 0;
  while (const auto line = lines_.Next()) {
    if (line->text.empty()) continue;
    FindColumns();
    const Fields fields = ValuesOf(*line);
    if (width == 0) width = fields.size();
    const auto first = static_cast<std::size_t>(columns_->first) + 1;
    std::string fault;
    if (fields.size() != width) fault = WidthFault(fields.size(), static_cast<int>(width));
    if (width <= first) fault = fmt::format("has {} columns; x and a height are needed", width);
    double x = 0.0;
    if (fault.empty()) fault = ParseNumber(fields, columns_->first, x);
    for (std::size_t i = first; i < width && fault.empty(); ++i) {
      if (transposed_.size() <= i - first) {
        transposed_.emplace_back();
        transposed_.back().row = transposed_.back().line = i - first + 1;
      }
      RawRow& row = transposed_[i - first];
      row.x_m.push_back(x * options_.text.scale.unit_m);
      row.height_m.push_back(0.0F);
      fault = ParseHeight(fields, static_cast<int>(i), row.height_m.back());
    }
    if (IsDamaged(fault)) {
      throw InputError(fmt::format("line {}{}{}", line->number,
                                   fault.starts_with("column") ? ", " : " ", fault));
    }
    row_ = 1;  // from now on a word is no header
  }
}

}  // namespace rangegrasp::seam
