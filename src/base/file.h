#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace rangegrasp::base {

/// The whole file as bytes.
/// @throws InputError naming the file if it is missing, a folder or not readable.
std::string ReadFile(const std::filesystem::path& file);

/// The same, where a file without a byte is an error too.
std::string ReadNonEmptyFile(const std::filesystem::path& file);

/// Writes the file whole, making its folder where there is none. A file of that name is replaced in
/// one step: a run that is killed leaves the old one or the new one.
/// @throws RunError naming the file if the bytes did not reach the disk, InputError if the folder
/// cannot be made.
void WriteFile(const std::filesystem::path& file, std::string_view bytes);

/// Makes the folder that a file is to stand in. @throws InputError naming the folder.
void MakeFolderOf(const std::filesystem::path& file);

/// What a file's name ends with, in small letters: ".ply" of "Cup.PLY".
std::string EndingOf(const std::filesystem::path& file);

}  // namespace rangegrasp::base
