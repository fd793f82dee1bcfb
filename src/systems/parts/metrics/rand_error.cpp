#include "parts/metrics/rand_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace rangegrasp::parts {
namespace {

double Pairs(std::size_t n) {
  return 0.5 * static_cast<double>(n) * (static_cast<double>(n) - 1.0);
}

/// The sum of C(n, 2) over the groups of equal values.
template <class T>
double PairsInGroups(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  double sum = 0.0;
  for (auto first = values.begin(); first != values.end();) {
    const auto last = std::upper_bound(first, values.end(), *first);
    sum += Pairs(static_cast<std::size_t>(last - first));
    first = last;
  }
  return sum;
}

}  // namespace

double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  if (a.size() != b.size() || a.size() < 2) {
    throw std::invalid_argument(
        fmt::format("RandError: labellings of {} and {} elements; they must be as long, >= 2",
                    a.size(), b.size()));
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> both;
  both.reserve(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) both.emplace_back(a[i], b[i]);
  return (PairsInGroups(std::vector(a.begin(), a.end())) +
          PairsInGroups(std::vector(b.begin(), b.end())) - 2.0 * PairsInGroups(std::move(both))) /
         Pairs(a.size());
}

}  // namespace rangegrasp::parts
