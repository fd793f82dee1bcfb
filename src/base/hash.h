#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rangegrasp::base {

/// FNV-1a, 64 bits, of bytes, going on from `state`. Names versions of files in a stamp; not for
/// security.
std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325u);

/// 16 hexadecimal digits.
std::string Hex(std::uint64_t value);

}  // namespace rangegrasp::base
