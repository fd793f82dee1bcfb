#include "seam/internal/text_lines.h"

#include <algorithm>
#include <cmath>

#include "base/number.h"

namespace rangegrasp::seam {
namespace {

// Lines beyond are no profiles (a wrong file, a stuck pipe) and must not fill the memory.
constexpr std::size_t kLongestLine = std::size_t{4} << 20U;
constexpr std::string_view kBlanks = " \t";

// Tabs that separate must stay.
std::string_view Trimmed(std::string_view text, std::string_view blanks = kBlanks) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string_view Unquoted(std::string_view field) {
  const bool quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
  return quoted ? Trimmed(field.substr(1, field.size() - 2)) : field;
}

std::vector<std::string_view> BetweenBlanks(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t end = 0;;) {
    const std::size_t begin = line.find_first_not_of(kBlanks, end);
    if (begin == std::string_view::npos) return fields;
    end = std::min(line.find_first_of(kBlanks, begin), line.size());
    fields.push_back(Unquoted(line.substr(begin, end - begin)));
  }
}

std::vector<std::string_view> Between(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    fields.push_back(Unquoted(Trimmed(line.substr(begin, end - begin))));
    if (end == line.size()) return fields;
    begin = end + 1;
  }
}

char SeparatorOf(std::string_view line, const TextFormat& format) {
  switch (format.separator) {
    case TextSeparator::kComma:
      return ',';
    case TextSeparator::kSemicolon:
      return ';';
    case TextSeparator::kTab:
      return '\t';
    case TextSeparator::kBlank:
      return ' ';
    case TextSeparator::kAuto:
      break;
  }
  if (line.find(';') != std::string_view::npos) return ';';
  return !format.decimal_comma && line.find(',') != std::string_view::npos ? ',' : ' ';
}

}  // namespace

std::vector<std::string_view> FieldsOf(std::string_view line, const TextFormat& format) {
  const char separator = SeparatorOf(line, format);
  return separator == ' ' ? BetweenBlanks(line) : Between(line, separator);
}

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

bool IsNoValue(std::string_view field) {
  if (field.empty() || field == "-") return true;
  return field.size() == 3 && (field[0] == 'n' || field[0] == 'N') &&
         (field[1] == 'a' || field[1] == 'A') && (field[2] == 'n' || field[2] == 'N');
}

std::optional<TextLine> TextLines::Next() {
  while (auto line = InSection()) {
    if (!line->text.empty() && line->text.front() == '#') continue;
    if (!TakesHeader(*line)) return line;
  }
  return std::nullopt;
}

// Before the first line of numbers.
bool TextLines::TakesHeader(const TextLine& line) {
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

std::optional<TextLine> TextLines::InSection() {
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
std::optional<TextLine> TextLines::ReadLine() {
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

}  // namespace rangegrasp::seam
