#include "base/hash.h"

#include <fmt/format.h>

namespace rangegrasp::base {

std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state) {
  for (const char c : bytes) {
    state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  return state;
}

std::string Hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

}  // namespace rangegrasp::base
