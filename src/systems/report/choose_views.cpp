#include "report/choose_views.h"

#include <algorithm>
#include <numeric>

namespace rangegrasp::report {
namespace {

std::vector<std::size_t> Spread(const std::vector<std::size_t>& all, std::size_t max) {
  std::vector<std::size_t> some;
  const std::size_t count = std::min(max, all.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

}  // namespace

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
  auto some = Spread({chosen.begin(), others}, kFailuresShown);
  const auto successes = Spread({others, chosen.end()}, kSuccessesShown);
  some.insert(some.end(), successes.begin(), successes.end());
  std::sort(some.begin(), some.end());
  return some;
}

std::vector<std::size_t> Fitting(const std::vector<std::uintmax_t>& sizes,
                                 std::uintmax_t max_bytes) {
  std::vector<std::size_t> all(sizes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (std::size_t count = all.size(); count > 0; --count) {
    const auto kept = Spread(all, count);
    std::uintmax_t sum = 0;
    for (const std::size_t i : kept) sum += sizes[i];
    if (sum <= max_bytes) return kept;
  }
  return {};
}

}  // namespace rangegrasp::report
