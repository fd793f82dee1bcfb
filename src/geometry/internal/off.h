#pragma once

#include <filesystem>
#include <string_view>

namespace rangegrasp::geometry::internal {

/// Checks the text of an OFF file before assimp reads it, which allocates what the counts say and
/// drops what it cannot place. Binary OFF is left to assimp.
/// @throws core::InputError naming file and line: counts that the file cannot hold, fewer faces
/// than declared, a face with a vertex that is not there.
void CheckOff(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
