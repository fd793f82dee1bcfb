#pragma once

#include <filesystem>
#include <span>

#include "geometry/draw/canvas.h"
#include "geometry/mesh_file.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Reads OFF, OBJ, STL, PLY, glTF or PCD as it is; a PLY without faces and a PCD are clouds,
/// which have no polygons. @throws base::InputError naming the file.
geometry::PolygonMesh ReadPolygons(const std::filesystem::path& file);
/// ReadPolygons and MakeShape of the triangles. @throws base::InputError naming the file.
Shape ReadShape(const std::filesystem::path& file);

/// .seg: line i is the label of element i. @throws base::InputError naming file and line (also if
/// there are not `elements`).
Labels ReadLabels(const std::filesystem::path& file, std::size_t elements);
/// The same, as many elements as there are lines.
Labels ReadLabels(const std::filesystem::path& file);
/// @throws base::RunError if it cannot be written whole.
void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels);
/// Binary PLY with a color a face (mesh) or a point (cloud). @throws base::RunError;
/// std::invalid_argument if there is not one label an element.
void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels);

/// PartColor for drawing, opaque.
draw::Color PaintOf(std::int32_t label);

/// A mesh with its faces, or a cloud (no triangles) with its points, in the colors of their labels;
/// points that are not finite, and faces with one, are left out.
/// @throws std::invalid_argument if there is not one label a face (a point).
draw::Canvas DrawLabels(const geometry::TriangleMesh& shape, std::span<const std::int32_t> labels);

/// A view of the whole of a shape, from the front right and above. Any unit.
/// @param up  the shape's axis that points up: 0, 1, 2 for x, y, z; the front is the next axis but
///            one, against its direction for z (-y), along it for y (+z).
/// @throws std::invalid_argument without a finite point, or for another axis.
draw::View LookAtShape(geometry::PointSpan points, int up);

/// Writes the parts of a shape as BASE.seg (labels), BASE.ply (in colors) and BASE.png.
/// @param labels  one a triangle or point; .seg has one a polygon, and its triangles are shown so.
/// @param up  as LookAtShape's.
/// @throws base::RunError if a file cannot be written, base::InputError if the folder cannot be
/// made, std::invalid_argument if there is not one label an element.
void WriteParts(const std::filesystem::path& base, const geometry::PolygonMesh& input,
                std::span<const std::int32_t> labels, int up);

}  // namespace rangegrasp::parts
