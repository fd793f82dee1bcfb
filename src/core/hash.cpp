#include "core/hash.h"

#include <array>
#include <cstdio>

namespace rangegrasp::core {

std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state) {
  for (const char c : bytes) {
    state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  return state;
}

std::string Hex(std::uint64_t value) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

}  // namespace rangegrasp::core
