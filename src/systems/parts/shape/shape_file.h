#pragma once

#include <filesystem>
#include <span>

#include "geometry/draw/canvas.h"
#include "geometry/mesh_file.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Reads OFF, OBJ, STL, PLY, glTF, PCD, NPY or XYZ without changes. A PLY without faces and the
/// last three are clouds, which have no polygons.
/// @throws base::InputError naming the file.
geometry::PolygonMesh ReadPolygons(const std::filesystem::path& file);
/// MakeShape of what ReadPolygons has read.
/// @throws base::InputError naming the file.
Shape ShapeOf(const geometry::PolygonMesh& polygons, const std::filesystem::path& file);
/// ReadPolygons, then ShapeOf.
/// @throws base::InputError naming the file.
Shape ReadShape(const std::filesystem::path& file);

/// Reads .seg: line i is the label of element i.
/// @throws base::InputError naming file and line (also if there are not `elements` lines).
Labels ReadLabels(const std::filesystem::path& file, std::size_t elements);
/// The same for as many elements as there are lines.
Labels ReadLabels(const std::filesystem::path& file);
/// @throws base::RunError if the file cannot be written completely.
void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels);
/// Writes binary PLY with a color per face (mesh) or per point (cloud).
/// @throws base::RunError if the file cannot be written completely.
void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels);

/// PartColor as an opaque color for drawing.
draw::Color PaintOf(std::int32_t label);

/// Draws a mesh as faces, or a cloud (no triangles) as points, in the colors of their labels.
/// Points that are not finite, and faces with such a point, are left out.
draw::Canvas DrawLabels(const geometry::TriangleMesh& shape, std::span<const std::int32_t> labels);

/// A view of a whole shape from the front (-y) right and above (z), in any unit.
draw::View LookAtShape(geometry::PointSpan points);

/// Writes the parts of a shape as BASE.seg (labels), BASE.ply (colored) and BASE.png.
/// @param labels  one per triangle or point; .seg has one per polygon, and the triangles are shown
///                with the labels of their polygons
/// @throws base::RunError if a file cannot be written, base::InputError if the folder cannot be
/// made.
void WriteParts(const std::filesystem::path& base, const geometry::PolygonMesh& input,
                std::span<const std::int32_t> labels);

}  // namespace rangegrasp::parts
