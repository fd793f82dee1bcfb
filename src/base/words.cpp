#include "base/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <ranges>

#include "base/error.h"

namespace rangegrasp::base {
namespace {

// Minimum length of a word that may be a part of a longer one.
constexpr std::size_t kMinPart = 3;
// One of as many letters of a misspelt word may be wrong, rounded up: clang's rule for suggestions.
constexpr std::size_t kLettersPerError = 3;

std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string MustBeOneOf(std::string_view word, const std::vector<std::string>& words) {
  return fmt::format("'{}' must be one of {}{}", Excerpt(word), Join(words),
                     Suggestion(word, words, "; nearest: {}"));
}

std::size_t WordPosition(std::string_view word, const std::vector<std::string>& words,
                         const std::string& what) {
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) throw InputError(what + ": " + MustBeOneOf(word, words));
  return static_cast<std::size_t>(found - words.begin());
}

std::string NearestWord(std::string_view word, const std::vector<std::string>& words) {
  const auto distance = [&](const std::string& other) { return EditDistance(word, other); };
  const auto nearest = std::ranges::min_element(words, {}, distance);
  if (nearest == words.end()) return "";
  const bool near = distance(*nearest) <= (word.size() + kLettersPerError - 1) / kLettersPerError;
  if (word.size() < kMinPart || distance(*nearest) < 2) return near ? *nearest : "";
  const auto begun = std::ranges::find_if(
      words, [&](const std::string& other) { return other.starts_with(word); });
  if (begun != words.end()) return *begun;
  if (near) return *nearest;
  const auto longer = std::ranges::find_if(
      words, [&](const std::string& other) { return other.find(word) != std::string::npos; });
  return longer != words.end() ? *longer : "";
}

std::string Suggestion(std::string_view word, const std::vector<std::string>& words,
                       std::string_view text) {
  const std::string nearest = NearestWord(word, words);
  return nearest.empty() ? "" : fmt::format(fmt::runtime(text), nearest);
}

std::string Join(const std::vector<std::string>& words, std::string_view separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

std::string Counted(std::int64_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string Excerpt(std::string_view text) {
  constexpr std::size_t kShownBytes = 80;  // a line of a terminal; a number needs 24
  std::size_t size = std::min(text.size(), kShownBytes);
  const auto is_inside_letter = [&](std::size_t i) {  // of UTF-8
    return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xc0U) == 0x80;
  };
  while (size > 0 && is_inside_letter(size)) --size;
  std::string shown(text.substr(0, size));
  std::ranges::replace_if(
      shown, [](unsigned char c) { return c < ' '; }, ' ');
  return size < text.size() ? shown + "..." : shown;
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (const auto& part : std::views::split(text, separator)) {
    parts.emplace_back(part.begin(), part.end());
  }
  if (parts.empty()) parts.emplace_back();
  return parts;
}

bool IsUtf8(std::string_view text) {
  std::size_t left = 0;  // remaining bytes of the sequence
  std::uint32_t code = 0, least = 0;
  for (const unsigned char c : text) {
    if (left == 0) {
      if (c < 0x80) continue;
      left = c >= 0xf0 ? 3 : c >= 0xe0 ? 2 : 1;
      if (c < 0xc0 || c >= 0xf8) return false;
      code = c & (0x3fU >> left);
      least = left == 1 ? 0x80 : left == 2 ? 0x800 : 0x10000;
      continue;
    }
    if ((c & 0xc0U) != 0x80) return false;
    code = code << 6U | (c & 0x3fU);
    if (--left > 0) continue;
    if (code < least || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return false;
  }
  return left == 0;
}

std::string XmlEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return escaped;
}

}  // namespace rangegrasp::base
