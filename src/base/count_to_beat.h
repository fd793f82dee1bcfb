#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>

namespace rangegrasp::base {

/// How many of the items have a property, for a search that keeps the best count (RANSAC): gives up
/// as soon as the count cannot be larger than `to_beat` any more, and is then not complete, but at
/// most `to_beat`.
template <std::ranges::random_access_range Items, class Property>
std::size_t CountToBeat(const Items& items, std::size_t to_beat, const Property& has_property) {
  constexpr std::size_t kBlock = 64;  // items between two looks at whether to give up
  const std::size_t size = std::ranges::size(items);
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
