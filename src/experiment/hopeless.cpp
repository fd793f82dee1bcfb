#include "experiment/hopeless.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace rangegrasp::experiment {
namespace {

using Count = std::pair<std::string, int>;

// Most frequent first, equals by their text.
std::vector<Count> Ranked(const std::map<std::string, int>& counts) {
  std::vector<Count> ranked(counts.begin(), counts.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Count& a, const Count& b) { return a.second > b.second; });
  return ranked;
}

}  // namespace

std::vector<Case> InTurn(const std::vector<Case>& cases) {
  std::map<std::string, int> of_group;
  std::vector<std::pair<int, Case>> turns;
  for (const Case& c : cases) turns.emplace_back(of_group[c.group]++, c);
  std::stable_sort(turns.begin(), turns.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Case> in_turn;
  for (auto& [turn, c] : turns) in_turn.push_back(std::move(c));
  return in_turn;
}

std::optional<std::string> SameFailure(const std::vector<Record>& records,
                                       const std::string& success) {
  if (records.empty()) return std::nullopt;
  const Result& first = records.front().result;
  std::map<std::string, int> details;
  for (const Record& record : records) {
    const Result& result = record.result;
    if (result.outcome == success || result.outcome != first.outcome ||
        result.stage != first.stage) {
      return std::nullopt;
    }
    if (!result.detail.empty()) ++details[result.detail];
  }
  std::string text = first.outcome;
  if (!first.stage.empty()) text += " in " + first.stage;
  const auto ranked = Ranked(details);
  return ranked.empty() ? text : text + ": " + ranked.front().first;
}

std::vector<std::string> CrashReasons(const std::vector<Record>& records) {
  std::map<std::string, int> reasons;
  for (const Record& record : records) {
    const Result& result = record.result;
    if (result.outcome != kCrashed) continue;
    ++reasons[(result.stage.empty() ? "" : result.stage + ": ") +
              (result.detail.empty() ? "no reason given" : result.detail)];
  }
  std::vector<std::string> texts;
  for (const auto& [reason, count] : Ranked(reasons)) {
    texts.push_back(fmt::format("{} x {}", count, reason));
  }
  return texts;
}

}  // namespace rangegrasp::experiment
