#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/cloud_file.h"

namespace rangegrasp::geometry::internal {

/// Reads the bytes of a PCD file (ascii, binary, binary_compressed).
/// @throws base::InputError naming file and line.
CloudFile ReadPcd(const std::filesystem::path& file, std::string_view bytes);

/// Expands LZF data (Lehmann's liblzf format, as PCD's binary_compressed has it) to exactly `size`
/// bytes; nullopt if the data are broken.
std::optional<std::string> ExpandLzf(std::string_view data, std::size_t size);

}  // namespace rangegrasp::geometry::internal
