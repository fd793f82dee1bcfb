#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rangegrasp::base {

/// The value at position floor(share * (n - 1)) of the sorted values, without interpolation.
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

/// Quantile, interpolated linearly between the two values next to position share * (n - 1) (Hyndman
/// and Fan 1996, type 7). O(n); share from 0 to 1; n >= 1.
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

/// The median: the mean of the two middle values if n is even. O(n); n >= 1.
template <typename T>
T MedianOf(std::vector<T> values) {
  return InterpolatedQuantileOf(std::move(values), 0.5);
}

/// Counts the items (random access) with a property, for a search that keeps the best count
/// (RANSAC). Stops when the count can no longer exceed `to_beat`, and then returns at most that.
template <class Items, class Property>
std::size_t CountToBeat(const Items& items, std::size_t to_beat, const Property& has_property) {
  constexpr std::size_t kBlock = 64;  // items between two checks for an early stop
  const std::size_t size = items.size();
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < size && count + (size - begin) > to_beat; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, size);
    for (std::size_t i = begin; i < end; ++i) {
      count += static_cast<std::size_t>(has_property(items[i]));
    }
  }
  return count;
}

}  // namespace rangegrasp::base
