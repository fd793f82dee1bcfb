#include "seam/internal/profile_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

// Longer lines are not profiles (a wrong file, a stuck pipe) and must not fill the memory.
constexpr std::size_t kLongestLine = std::size_t{4} << 20U;
// A sensor's line has fewer points. Limits the memory for a text in which a profile never ends.
constexpr std::size_t kMaxPoints = 65536;
// Number of valid rows that determine the width, and maximum number of rows held back for this.
constexpr std::size_t kRowsOfWidth = 3;
constexpr std::size_t kMaxRowsHeld = 16;
constexpr std::string_view kBlanks = " \t";

// ---- fields of a line ----

// Part of a file for a message: short, and without control characters.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kMaxShown = 24;  // enough for a number with all its digits
  std::string shown(text.substr(0, kMaxShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + shown + (text.size() > kMaxShown ? "..." : "") + "'";
}

// Tabs that are separators must be excluded from `blanks`.
std::string_view Trimmed(std::string_view text, std::string_view blanks = kBlanks) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string_view Unquoted(std::string_view field) {
  const bool quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
  return quoted ? Trimmed(field.substr(1, field.size() - 2)) : field;
}

char SeparatorOf(std::string_view line, const TextFormat& format) {
  constexpr std::string_view kSeparators = ",;\t ";  // of kComma, kSemicolon, kTab, kBlank
  if (format.separator != TextSeparator::kAuto) {
    return kSeparators[static_cast<std::size_t>(format.separator) - 1];
  }
  if (line.find(';') != std::string_view::npos) return ';';
  return !format.decimal_comma && line.find(',') != std::string_view::npos ? ',' : ' ';
}

using Fields = std::vector<std::string_view>;

// Fields are trimmed and without quotes.
Fields FieldsOf(std::string_view line, const TextFormat& format) {
  const char separator = SeparatorOf(line, format);
  Fields fields;
  for (std::size_t begin = 0;;) {
    if (separator == ' ') {
      begin = line.find_first_not_of(kBlanks, begin);
      if (begin == std::string_view::npos) return fields;
      const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
      fields.push_back(Unquoted(line.substr(begin, end - begin)));
      begin = end;
    } else {
      const std::size_t end = std::min(line.find(separator, begin), line.size());
      fields.push_back(Unquoted(Trimmed(line.substr(begin, end - begin))));
      if (end == line.size()) return fields;
      begin = end + 1;
    }
  }
}

// Nullopt if it is not a number, or not one that a double can hold.
std::optional<double> NumberOf(std::string_view field, bool decimal_comma) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  std::string pointed;
  if (decimal_comma && field.find(',') != std::string_view::npos) {
    if (field.find('.') != std::string_view::npos) return std::nullopt;
    pointed = field;
    pointed[pointed.find(',')] = '.';
    field = pointed;
  }
  const auto number = base::NumberFrom<double>(field);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// Empty, "-" or "nan".
bool IsNoValue(std::string_view field) {
  if (field.empty() || field == "-") return true;
  return std::ranges::equal(field, std::string_view("nan"), {}, [](char c) { return c | 0x20; });
}

// ---- lines of a text ----

struct TextLine {
  std::size_t number = 0;
  bool too_long = false;
  std::string text;  // trimmed; may be empty
};

// Lines as they arrive, without header, unwanted sections, comments (#) and line ends.
class TextLines {
 public:
  TextLines(std::istream& in, const TextFormat& format) : in_(in), format_(format) {}

  std::optional<TextLine> Next() {
    while (auto line = InSection()) {
      if (!line->text.empty() && line->text.front() == '#') continue;
      if (!TakesHeader(*line)) return line;
    }
    return std::nullopt;
  }

  // The columns' names; empty if there is no header.
  const std::vector<std::string>& header() const { return header_; }

 private:
  // True for lines before the first line of numbers; keeps the header.
  bool TakesHeader(const TextLine& line) {
    const bool counted = left_out_ < format_.header_lines;
    const bool named = !format_.header.empty() && !has_header_;
    if (!counted && !named) return false;
    const auto fields = FieldsOf(line.text, format_);
    if (counted) ++left_out_;
    if (named && (fields.empty() || fields[0] != format_.header)) return true;
    header_.assign(fields.begin(), fields.end());
    has_header_ = true;
    return true;
  }

  std::optional<TextLine> InSection() {
    while (auto line = ReadLine()) {
      if (format_.sections.empty()) return line;
      if (!in_section_) {
        in_section_ = std::ranges::find(format_.sections, line->text) != format_.sections.end();
      } else if (line->text == "End") {
        in_section_ = false;
        has_header_ = false;
      } else {
        return line;
      }
    }
    return std::nullopt;
  }

  // The next line without its end (LF or CRLF).
  std::optional<TextLine> ReadLine() {
    TextLine line;
    bool any = false;
    std::streambuf* buffer = in_.rdbuf();
    for (int c = buffer->sbumpc(); c != std::char_traits<char>::eof(); c = buffer->sbumpc()) {
      any = true;
      if (c == '\n') break;
      if (line.text.size() < kLongestLine) {
        line.text.push_back(static_cast<char>(c));
      } else {
        line.too_long = true;
      }
    }
    if (!any) return std::nullopt;
    line.number = ++number_;
    if (number_ == 1 && line.text.starts_with("\xEF\xBB\xBF")) line.text.erase(0, 3);
    line.text = Trimmed(line.text, format_.separator == TextSeparator::kTab ? " \r" : " \t\r");
    return line;
  }

  std::istream& in_;
  TextFormat format_;
  std::vector<std::string> header_;
  std::size_t number_ = 0;
  int left_out_ = 0;  // header lines read so far
  bool has_header_ = false;
  bool in_section_ = false;
};

// ---- rows of a text ----

class TextRows {
 public:
  TextRows(std::istream& in, const ProfileFileOptions& options)
      : options_(options), lines_(in, options_.text) {}

  std::optional<RawRow> Next() {
    if (!settled_ && options_.columns == 0 && held_.empty()) FixWidth();
    return held_.empty() ? NextOfLayout() : TakeFirst(held_);
  }

 private:
  // Column indices from 0; below 0: no such column.
  struct Columns {
    int time = -1, encoder = -1, axis = -1, profile = -1, z = -1, first = 0;
  };

  void FixWidth() {
    std::vector<std::size_t> widths;  // that valid rows have or may have
    for (std::size_t valid = 0; !settled_ && held_.size() < kMaxRowsHeld && valid < kRowsOfWidth;) {
      auto row = NextOfLayout();
      if (!row) break;
      held_.push_back(std::move(*row));
      const RawRow& last = held_.back();
      if (!last.fault.empty()) continue;
      const auto agrees = [&](std::size_t width) { return width == last.width; };
      settled_ = last.width == 0 || (!last.open_end && std::ranges::any_of(widths, agrees));
      ++valid;
      widths.push_back(last.width);
      if (last.open_end) widths.push_back(last.width + 1);
    }
    if (widths.empty()) return;
    const std::size_t width = settled_ ? held_.back().width : widths.front();
    options_.columns = static_cast<int>(width);
    for (RawRow& row : held_) {
      if (!row.fault.empty() || width == 0 || row.width == width) continue;
      if (row.open_end && row.width + 1 == width) {
        row.height_m.push_back(std::numeric_limits<float>::quiet_NaN());
      } else {
        MarkDamaged(row, WidthFault(row.width, options_.columns));
      }
    }
  }

  std::optional<RawRow> NextOfLayout() {
    if (options_.text.layout == TextLayout::kPoints) return NextOfPoints();
    if (options_.text.layout == TextLayout::kColumns) return NextOfColumns();
    return NextOfLines();
  }

  // -- which column is what --

  int Find(const std::string& name, const char* key) const {
    if (name.empty()) return -1;
    const auto number = base::NumberFrom<int>(name);
    if (number && *number >= 1) return *number - 1;
    const auto& header = lines_.header();
    const auto found = std::ranges::find(header, name);
    if (found != header.end()) return static_cast<int>(found - header.begin());
    throw InputError(
        fmt::format("{}: {} is neither a column number, from 1, nor in the header, which {}", key,
                    Quoted(name), header.empty() ? "is missing" : "has " + base::Join(header)));
  }

  // The next line that is not empty; also finds the columns.
  std::optional<TextLine> NextLine() {
    auto line = lines_.Next();
    while (line && line->text.empty()) line = lines_.Next();
    if (line) FindColumns();
    return line;
  }

  void FindColumns() {
    if (columns_) return;
    const TextFormat& text = options_.text;
    Columns c;
    c.time = Find(text.time_column, "time_column");
    c.encoder = Find(text.encoder_column, "encoder_column");
    c.axis = Find(text.axis_column, "axis_column");
    c.profile = Find(text.profile_column, "profile_column");
    c.first = std::max({c.time, c.encoder, c.axis, c.profile, -1}) + 1;
    if (!text.first_column.empty()) c.first = Find(text.first_column, "first_column");
    c.z = text.z_column.empty() ? c.first + 1 : Find(text.z_column, "z_column");
    columns_ = c;
    if (text.x_in_header) ReadHeaderX();
  }

  void ReadHeaderX() {
    const auto& header = lines_.header();
    if (header.empty()) throw InputError("x_in_header: there is no header (header_lines, header)");
    Fields fields(header.begin(), header.end());
    if (std::ssize(fields) > columns_->first && fields.back().empty()) fields.pop_back();
    try {
      ReadAllX(fields, header_x_m_);
    } catch (const InputError& error) {
      throw InputError(std::string("header, ") + error.what());
    }
  }

  // -- fields; an InputError says what is wrong with the row --

  // Whether the empty field after a separator at the end of a line is no missing height.
  bool EndsWithSeparator(const Fields& fields) const {
    if (fields.size() < 2 || !fields.back().empty()) return false;
    const auto count = std::ssize(fields) - columns_->first;
    const auto width = options_.columns != 0 ? options_.columns : std::ssize(RowX());
    if (width != 0) return count == width + 1;
    return options_.text.layout != TextLayout::kPairs || count % 2 != 0;
  }

  // x that all rows have in common; empty: none.
  const std::vector<double>& RowX() const {
    return columns_->axis >= 0 && !axis_x_m_.empty() ? axis_x_m_ : header_x_m_;
  }

  // NaN where there is no value.
  double NumberAt(const Fields& fields, int field) const {
    if (field >= std::ssize(fields)) {
      throw InputError(fmt::format("has {}, but no column {}",
                                   base::Counted(fields.size(), "column"), field + 1));
    }
    const std::string_view shown = fields[static_cast<std::size_t>(field)];
    if (IsNoValue(shown)) return std::numeric_limits<double>::quiet_NaN();
    if (const auto number = NumberOf(shown, options_.text.decimal_comma)) return *number;
    std::string fault =
        fmt::format("column {}: {} is not a number; a missing value is nan, - or empty", field + 1,
                    Quoted(shown));
    const bool comma = shown.find(',') != std::string_view::npos;
    if (comma && !options_.text.decimal_comma) {
      fault += "; for a decimal comma use decimal_comma (--decimal-comma)";
    }
    if (row_ == 0) fault += "; for a header use header_lines (--set file.header_lines=1)";
    throw InputError(fault);
  }

  double XAt(const Fields& fields, int field) const {
    return NumberAt(fields, field) * options_.text.scale.unit_m;
  }

  float HeightAt(const Fields& fields, int field) const {
    const double number = NumberAt(fields, field);
    try {
      return HeightOf(number, options_.text.scale, options_);
    } catch (const InputError& error) {
      const std::string shown = Quoted(fields[static_cast<std::size_t>(field)]);
      // Camera rows have no unit, and a unit that was given is not in doubt.
      const bool default_unit = options_.text.scale.unit_m == HeightScale{}.unit_m;
      throw InputError(fmt::format(
          "column {}: {} {}{}", field + 1, shown, error.what(),
          default_unit ? "; for another unit use unit_mm (--unit um or --unit m)" : ""));
    }
  }

  void ReadAllX(const Fields& fields, std::vector<double>& x_m) const {
    x_m.clear();
    for (int i = columns_->first; i < std::ssize(fields); ++i) x_m.push_back(XAt(fields, i));
  }

  void ReadPoint(const Fields& fields, int x, int z, RawRow& row) const {
    row.x_m.push_back(XAt(fields, x));
    row.height_m.push_back(HeightAt(fields, z));
  }

  std::optional<double> StampAt(const Fields& fields, int column, double unit) const {
    if (column < 0) return std::nullopt;
    const double number = NumberAt(fields, column);
    if (!std::isnan(number)) return number * unit;
    throw InputError(fmt::format(
        "column {}: the number is missing; time and encoder columns need one in every row",
        column + 1));
  }

  void ReadStamps(const Fields& fields, RawRow& row) const {
    row.time_s = StampAt(fields, columns_->time, options_.time_unit_s);
    row.position_m = StampAt(fields, columns_->encoder, options_.encoder_m);
  }

  void ReadHeights(const Fields& fields, RawRow& row) const {
    for (int i = columns_->first; i < std::ssize(fields); ++i) {
      row.height_m.push_back(HeightAt(fields, i));
    }
    row.x_m = RowX();
    if (row.x_m.empty() || row.x_m.size() == row.width) return;
    throw InputError(fmt::format("has {}, but {}", base::Counted(row.width, "height"),
                                 base::Counted(row.x_m.size(), "x value")));
  }

  void ReadPairs(const Fields& fields, RawRow& row) const {
    if (row.width % 2 != 0) {
      throw InputError(fmt::format("has {}; pairs of x and height need an even number",
                                   base::Counted(row.width, "column")));
    }
    for (int i = columns_->first; i < std::ssize(fields); i += 2) ReadPoint(fields, i, i + 1, row);
  }

  // -- a line is a profile --

  // False if the line is not a profile: its axis is not Z.
  bool ReadProfile(const TextLine& line, RawRow& row) {
    if (line.too_long) throw InputError("is too long for a profile");
    Fields fields = FieldsOf(line.text, options_.text);
    if (EndsWithSeparator(fields)) {
      fields.pop_back();
      row.open_end =
          options_.text.layout == TextLayout::kRows && options_.columns == 0 && RowX().empty();
    }
    if (columns_->axis >= std::ssize(fields)) {
      throw InputError(fmt::format("has {}; axis_column is {}",
                                   base::Counted(fields.size(), "column"), columns_->axis + 1));
    }
    if (columns_->axis >= 0) {
      const std::string_view axis = fields[static_cast<std::size_t>(columns_->axis)];
      if (axis == "X") ReadAllX(fields, axis_x_m_);
      if (axis != "Z") return false;
    }
    row.width = fields.size() - std::min(static_cast<std::size_t>(columns_->first), fields.size());
    if (row.width == 0) {
      throw InputError(
          fmt::format("has {}, but no height", base::Counted(fields.size(), "column")));
    }
    if (options_.columns != 0 && row.width != static_cast<std::size_t>(options_.columns)) {
      throw InputError(WidthFault(row.width, options_.columns));
    }
    ReadStamps(fields, row);
    if (options_.text.layout == TextLayout::kPairs) {
      ReadPairs(fields, row);
    } else {
      ReadHeights(fields, row);
    }
    return true;
  }

  std::optional<RawRow> NextOfLines() {
    while (const auto line = NextLine()) {
      RawRow row{.row = row_ + 1, .line = line->number};
      try {
        if (!ReadProfile(*line, row)) continue;
      } catch (const InputError& error) {
        MarkDamaged(row, error.what());
      }
      ++row_;
      return row;
    }
    return std::nullopt;
  }

  // -- a line is a point --

  std::optional<RawRow> NextOfPoints() {
    RawRow row;
    std::optional<std::string> profile;
    std::string fault;
    while (auto line = begun_ ? std::exchange(begun_, std::nullopt) : lines_.Next()) {
      if (line->text.empty() && row.line == 0) continue;
      if (line->text.empty()) break;
      FindColumns();
      const Fields fields = FieldsOf(line->text, options_.text);
      if (columns_->profile >= 0 && columns_->profile < std::ssize(fields)) {
        const std::string_view named = fields[static_cast<std::size_t>(columns_->profile)];
        if (profile && *profile != named) {
          begun_ = std::move(line);
          break;
        }
        profile = named;
      }
      if (!fault.empty()) continue;
      if (row.x_m.size() == kMaxPoints) {
        fault = fmt::format(
            "has more than {} points; an empty line or another number in profile_column ends a "
            "profile",
            kMaxPoints);
        break;
      }
      const bool first = row.line == 0;
      if (first) row.line = line->number;
      try {
        if (first) ReadStamps(fields, row);
        if (line->too_long) throw InputError("is too long for a point");
        ReadPoint(fields, columns_->first, columns_->z, row);
      } catch (const InputError& error) {
        fault = error.what();
        row.line = line->number;
      }
    }
    if (row.line == 0) return std::nullopt;
    row.row = ++row_;
    if (!fault.empty()) MarkDamaged(row, fault);
    return row;
  }

  // -- a column is a profile --

  std::optional<RawRow> NextOfColumns() {
    if (transposed_.empty()) ReadColumns();
    return TakeFirst(transposed_);
  }

  void ReadColumns() {
    std::size_t width = 0;
    while (const auto line = NextLine()) {
      Fields fields = FieldsOf(line->text, options_.text);
      const bool more = fields.size() > 1 && (width == 0 || fields.size() == width + 1);
      if (more && fields.back().empty()) fields.pop_back();  // the line ends with a separator
      if (width == 0) width = fields.size();
      try {
        ReadAcross(fields, width);
      } catch (const InputError& error) {
        const std::string fault = error.what();
        throw InputError(fmt::format("line {}{}{}", line->number,
                                     fault.starts_with("column") ? ", " : " ", fault));
      }
      row_ = 1;  // from now on a word cannot be a header
    }
  }

  // Adds a line's point to each profile.
  void ReadAcross(const Fields& fields, std::size_t width) {
    const auto first = static_cast<std::size_t>(columns_->first) + 1;
    if (width <= first) {
      throw InputError(
          fmt::format("has {}; x and a height are needed", base::Counted(width, "column")));
    }
    if (fields.size() != width)
      throw InputError(WidthFault(fields.size(), static_cast<int>(width)));
    const double x_m = XAt(fields, columns_->first);
    for (std::size_t i = first; i < width; ++i) {
      const std::size_t number = i - first + 1;
      if (transposed_.size() < number) transposed_.push_back({.row = number, .line = number});
      transposed_[number - 1].x_m.push_back(x_m);
      transposed_[number - 1].height_m.push_back(HeightAt(fields, static_cast<int>(i)));
    }
  }

  ProfileFileOptions options_;  // its columns are set by FixWidth
  TextLines lines_;
  std::deque<RawRow> held_;  // read while the width was unknown
  bool settled_ = false;
  std::optional<Columns> columns_;
  std::size_t row_ = 0;
  std::vector<double> axis_x_m_;  // from the last row with axis X
  std::vector<double> header_x_m_;
  std::optional<TextLine> begun_;  // kPoints: the first line of the next profile
  std::deque<RawRow> transposed_;  // kColumns: the profiles not yet returned
};

}  // namespace

void MarkDamaged(RawRow& row, const std::string& fault) {
  const std::string line = row.line != row.row ? fmt::format(" (line {})", row.line) : "";
  const char* between = fault.starts_with("column") ? ", " : " ";
  row = {.row = row.row,
         .line = row.line,
         .fault = fmt::format("row {}{}{}{}", row.row, line, between, fault)};
}

std::string WidthFault(std::size_t columns, int expected) {
  return fmt::format("has {} instead of {}", base::Counted(columns, "column"), expected);
}

float HeightOf(double number, const HeightScale& scale, const ProfileFileOptions& options) {
  const auto& none = scale.no_values;
  if (std::isnan(number) || std::ranges::find(none, number) != none.end()) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const double height = (number - scale.zero) * scale.unit_m;
  if (height >= options.min_height_m && height <= options.max_height_m) {
    return static_cast<float>(options.away ? -height : height);
  }
  throw InputError(
      fmt::format("is out of range; it must be from {:.6g} to {:.6g} (min_height_mm, "
                  "max_height_mm); if it stands for a missing value use no_values (--no-value "
                  "{:.10g})",
                  options.min_height_m / scale.unit_m + scale.zero,
                  options.max_height_m / scale.unit_m + scale.zero, number));
}

std::optional<RawRow> TakeFirst(std::deque<RawRow>& rows) {
  if (rows.empty()) return std::nullopt;
  RawRow row = std::move(rows.front());
  rows.pop_front();
  return row;
}

RowSource RowsOfText(std::istream& in, const ProfileFileOptions& options) {
  return [rows = std::make_shared<TextRows>(in, options)] { return rows->Next(); };
}

}  // namespace rangegrasp::seam
