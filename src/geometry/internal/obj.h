#pragma once

#include <filesystem>
#include <string_view>

#include "geometry/internal/polygon_soup.h"

namespace rangegrasp::geometry::internal {

/// Reads places and faces of an OBJ file; all else in it is passed over.
/// @throws base::InputError naming file and line: a vertex without three numbers, a face with a
/// vertex that is not there.
PolygonSoup ReadObj(const std::filesystem::path& file, std::string_view bytes);

}  // namespace rangegrasp::geometry::internal
