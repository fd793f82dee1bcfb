#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace rangegrasp::base {

/// The number that a whole text is, in decimal and without blanks; nullopt if it is none, or one
/// that the type cannot hold. "nan" and "inf" are numbers of a floating-point type.
template <typename Number>
std::optional<Number> NumberFrom(std::string_view text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

}  // namespace rangegrasp::base
