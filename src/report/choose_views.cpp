#include "report/choose_views.h"

#include <algorithm>
#include <numeric>

namespace rangegrasp::report {

std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice) {
  std::vector<std::size_t> chosen(records.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  if (choice == ViewChoice::kAll) return chosen;
  if (choice == ViewChoice::kNone) return {};
  // Successes behind all others.
  const auto others = std::stable_partition(chosen.begin(), chosen.end(), [&](std::size_t i) {
    return !success.empty() && records[i].result.outcome != success;
  });
  const std::vector<std::size_t> successes(others, chosen.end());
  chosen.erase(others, chosen.end());
  const std::size_t shown = std::min(kSuccessesShown, successes.size());
  for (std::size_t i = 0; i < shown; ++i) {
    chosen.push_back(successes[i * successes.size() / shown]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace rangegrasp::report
