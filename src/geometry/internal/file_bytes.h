#pragma once

#include <filesystem>
#include <string>

namespace rangegrasp::geometry::internal {

/// The file's bytes. @throws core::InputError if it is missing, a folder, empty or not readable.
std::string ReadBytes(const std::filesystem::path& file);

/// Writes the file whole. @throws core::RunError naming it if the bytes did not reach it.
void WriteBytes(const std::filesystem::path& file, const std::string& bytes);

/// Appends the bytes of a number as they are in memory.
template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace rangegrasp::geometry::internal
