#include "base/pattern.h"

#include <regex>

namespace rangegrasp::base {
namespace {

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
  if (!std::regex_search(begin, text.end(), found, std::regex(pattern))) return std::nullopt;
  return MatchOf(found, from);
}

std::vector<Match> AllMatches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<Match> matches;
  for (std::sregex_iterator found(text.begin(), text.end(), regex), end; found != end; ++found) {
    matches.push_back(MatchOf(*found, 0));
  }
  return matches;
}

}  // namespace rangegrasp::base
