#include "base/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/error.h"

namespace rangegrasp::base {
namespace {

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
  return fmt::format("'{}' must be one of {}; nearest: {}", word, Join(words),
                     NearestWord(word, words));
}

std::size_t WordPosition(std::string_view word, const std::vector<std::string>& words,
                         const std::string& what) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) {
    throw InputError(what + ": " + MustBeOneOf(word, words));
  }
  return static_cast<std::size_t>(found - words.begin());
}

std::string NearestWord(std::string_view word, const std::vector<std::string>& words) {
  const auto nearest = std::min_element(
      words.begin(), words.end(),
      [&](const auto& a, const auto& b) { return EditDistance(word, a) < EditDistance(word, b); });
  return nearest == words.end() ? "" : *nearest;
}

std::string Join(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += separator;
    text += words[i];
  }
  return text;
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = text.find(separator); end != std::string_view::npos;
       end = text.find(separator, begin)) {
    parts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  parts.emplace_back(text.substr(begin));
  return parts;
}

}  // namespace rangegrasp::base
