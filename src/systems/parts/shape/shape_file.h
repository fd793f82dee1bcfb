#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "geometry/mesh_file.h"
#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// Reads OFF, OBJ, STL, PLY, glTF or PCD as it is; a PLY without faces and a PCD are clouds,
/// which have no polygons. @throws base::InputError naming the file.
geometry::PolygonMesh ReadPolygons(const std::filesystem::path& file);
/// Its triangles alone. Triangle i of a file of triangles is triangle i.
geometry::TriangleMesh ReadInput(const std::filesystem::path& file);
/// ReadInput and MakeShape. @throws base::InputError naming the file.
Shape ReadShape(const std::filesystem::path& file);

/// .seg: line i is the label of element i. @throws base::InputError naming file and line (also if
/// there are not `elements`).
std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file, std::size_t elements);
/// The same, as many elements as there are lines.
std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file);
/// @throws base::RunError if it cannot be written whole.
void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels);
/// Binary PLY with a color a face (mesh) or a point (cloud). @throws base::RunError;
/// std::invalid_argument if there is not one label an element.
void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels);

}  // namespace rangegrasp::parts
