#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rangegrasp::base {

/// The value at position floor(share * (n - 1)) of the sorted values: one of them, no mean of two.
/// O(n). share from 0 to 1; n >= 1.
template <typename T>
T QuantileOf(std::vector<T> values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// The upper median: the value at position n / 2 of the sorted values. O(n); n >= 1.
template <typename T>
T UpperMedianOf(std::vector<T> values) {
  const auto k = static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// Linear between the two values next to position share * (n - 1) (Hyndman and Fan 1996, type 7).
/// O(n); share from 0 to 1; n >= 1.
template <typename T>
T InterpolatedQuantileOf(std::vector<T> values, double share) {
  const double position = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(low);
  std::nth_element(values.begin(), at, values.end());
  if (low + 1 == values.size()) return *at;
  const T t = static_cast<T>(position - static_cast<double>(low));
  return *at * (T{1} - t) + *std::min_element(at + 1, values.end()) * t;
}

/// The mean of both middle values where n is even. O(n); n >= 1.
template <typename T>
T MedianOf(std::vector<T> values) {
  return InterpolatedQuantileOf(std::move(values), 0.5);
}

}  // namespace rangegrasp::base
