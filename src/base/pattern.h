#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace rangegrasp::base {

/// Regular expressions (ECMAScript's). std::regex is compiled once, here: it takes 5 s of every
/// source that instantiates it.

/// Where a pattern matches a text.
struct Match {
  std::size_t begin = 0;            ///< in the text
  std::vector<std::string> groups;  ///< the first is all that matches; empty where not part of it

  std::size_t end() const { return begin + groups[0].size(); }
};

/// The first match from a place on. @throws std::regex_error if the pattern is none.
std::optional<Match> FindMatch(const std::string& text, const std::string& pattern,
                               std::size_t from = 0);

/// All that do not overlap, in their order. @throws std::regex_error as FindMatch.
std::vector<Match> AllMatches(const std::string& text, const std::string& pattern);

}  // namespace rangegrasp::base
