#include "base/pattern.h"

#include <map>
#include <regex>

namespace rangegrasp::base {
namespace {

// Caches compiled patterns: compiling one takes 30 to 300 us, and every trial reads models with the
// same few patterns.
const std::regex& Compiled(const std::string& pattern) {
  thread_local std::map<std::string, std::regex> compiled;
  return compiled.try_emplace(pattern, pattern).first->second;
}

Match MatchOf(const std::smatch& found, std::size_t from) {
  Match match{from + static_cast<std::size_t>(found.position()), {}};
  for (const auto& group : found) match.groups.push_back(group.str());
  return match;
}

}  // namespace

std::optional<Match> FindMatch(const std::string& text, const std::string& pattern,
                               std::size_t from) {
  std::smatch found;
  const auto begin = text.begin() + static_cast<std::ptrdiff_t>(from);
  if (!std::regex_search(begin, text.end(), found, Compiled(pattern))) return std::nullopt;
  return MatchOf(found, from);
}

std::vector<Match> AllMatches(const std::string& text, const std::string& pattern) {
  const std::regex& regex = Compiled(pattern);
  std::vector<Match> matches;
  for (std::sregex_iterator found(text.begin(), text.end(), regex), end; found != end; ++found) {
    matches.push_back(MatchOf(*found, 0));
  }
  return matches;
}

}  // namespace rangegrasp::base
