#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace rangegrasp::core {

/// FNV-1a, 64 bits, of bytes, going on from `state`. Names versions of files in a stamp; not for
/// security.
std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325u);

/// 16 hexadecimal digits.
std::string Hex(std::uint64_t value);

/// The whole file as bytes. @throws core::InputError naming the file if it cannot be read.
std::string ReadFile(const std::filesystem::path& file);

}  // namespace rangegrasp::core
