#pragma once

#include <filesystem>
#include <string_view>

#include "geometry/internal/polygon_soup.h"

namespace rangegrasp::geometry::internal {

/// Reads the text of an OFF file (OFF, COFF, NOFF, STOFF and what they make together).
/// @throws base::InputError naming file and line: counts that the file cannot hold, fewer faces
/// than declared, a face with a vertex that is not there, what is no number.
PolygonSoup ReadOff(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
