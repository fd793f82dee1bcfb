#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace rangegrasp::mjcf {

/// The line, from 1, of a position in a text.
int LineAt(std::string_view text, std::size_t at);

/// Checks an MJCF file, and those that it includes or attaches, for what the engine's parser and
/// compiler do not survive. All other mistakes are left to the engine's messages.
/// @throws base::InputError if the file cannot be read, or naming file and line if
/// - a file includes or attaches itself, directly or through others, or too many are nested,
/// - too many elements are inside each other,
/// - a file, or an asset of it, is a named pipe: the engine would wait for it,
/// - a texture or height field is too large.
void CheckFiles(const std::filesystem::path& mjcf);

}  // namespace rangegrasp::mjcf
