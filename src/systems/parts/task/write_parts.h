#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "geometry/mesh_file.h"

namespace rangegrasp::parts_task {

/// Leaves what was found of a shape as BASE.seg (labels), BASE.ply (in colors) and BASE.png.
/// @param labels  one a triangle or point. In .seg stands one a polygon of the file, and all
/// triangles of it are shown so.
/// @param up  the shape's axis that points up in the picture: 0, 1, 2 for x, y, z.
/// @throws base::RunError if a file cannot be written, base::InputError if the folder cannot be
/// made, std::invalid_argument if there is not one label an element.
void WriteParts(const std::filesystem::path& base, const geometry::PolygonMesh& input,
                std::span<const std::int32_t> labels, int up);

}  // namespace rangegrasp::parts_task
