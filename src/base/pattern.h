#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace rangegrasp::base {

/// Regular expressions (ECMAScript syntax). std::regex is compiled once, here: it adds 5 s to the
/// compile time of every source file that instantiates it.

/// Where a pattern matches a text.
struct Match {
  std::size_t begin = 0;            ///< position in the text
  std::vector<std::string> groups;  ///< [0]: the whole match; unmatched groups are empty

  std::size_t end() const { return begin + groups[0].size(); }
};

/// The first match from a position on. @throws std::regex_error if the pattern is invalid.
std::optional<Match> FindMatch(const std::string& text, const std::string& pattern,
                               std::size_t from = 0);

/// All non-overlapping matches, in order. @throws std::regex_error as FindMatch.
std::vector<Match> AllMatches(const std::string& text, const std::string& pattern);

}  // namespace rangegrasp::base
