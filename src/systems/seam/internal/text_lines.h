#pragma once

#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// A line of a text that is no comment.
struct TextLine {
  std::size_t number = 0;
  bool too_long = false;
  std::string text;  ///< trimmed; may be empty
};

/// Lines of a text as they arrive, without header, sections that are not wanted, comments (#) and
/// what ends a line.
class TextLines {
 public:
  TextLines(std::istream& in, const TextFormat& format) : in_(in), format_(format) {}
  std::optional<TextLine> Next();
  /// The columns' names; empty if there is no header.
  const std::vector<std::string>& header() const { return header_; }

 private:
  std::optional<TextLine> ReadLine();
  std::optional<TextLine> InSection();
  bool TakesHeader(const TextLine& line);

  std::istream& in_;
  const TextFormat& format_;
  std::vector<std::string> header_;
  std::size_t number_ = 0;
  int left_out_ = 0;  // of header_lines
  bool has_header_ = false;
  bool in_section_ = false;
};

/// The fields of a line, trimmed, without quotes.
std::vector<std::string_view> FieldsOf(std::string_view line, const TextFormat& format);

/// A field's number; nullopt if it is none, or one that no double holds.
std::optional<double> NumberOf(std::string_view field, bool decimal_comma);

/// Whether a field says that there is no number: nothing, "-" or "nan".
bool IsNoValue(std::string_view field);

}  // namespace rangegrasp::seam
