#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

/// A mesh or a point cloud made ready for segmentation: finite, without duplicate or unused points.
/// Elements are what gets a label: the faces of a mesh, the points of a cloud.
struct Shape {
  geometry::Points points;                          ///< vertices or points [any unit]
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< empty: a cloud
  /// For each element of the input the element here, -1 where it was left out (not finite, out of
  /// range, without area); a point of a cloud that stands twice maps to the one that is kept.
  std::vector<std::int32_t> element_of_input;

  bool IsMesh() const { return !faces.empty(); }
  std::size_t Elements() const { return IsMesh() ? faces.size() : points.size(); }
};

/// Cleans a mesh or (without triangles) a cloud.
/// @throws core::InputError saying what is wrong: fewer than 4 finite points, all points in a
/// plane, no face left.
Shape MakeShape(const geometry::TriangleMesh& mesh);
/// Reads OFF, OBJ, STL, PLY or PCD as it is; a PLY without faces and a PCD are clouds. Triangle i
/// of the file is triangle i; polygons are cut into triangles where they stand.
/// @throws core::InputError naming the file.
geometry::TriangleMesh ReadInput(const std::filesystem::path& file);
/// ReadInput and MakeShape. @throws core::InputError naming the file.
Shape ReadShape(const std::filesystem::path& file);

/// Faces that share an edge. Non-manifold edges join all their faces (those of more than 16 in a
/// row); 3 slots a face are not assumed.
struct FaceGraph {
  std::vector<std::uint32_t> begin;  ///< faces + 1; neighbours of face i are [begin[i], begin[i+1])
  std::vector<std::uint32_t> neighbor;
  std::vector<std::array<std::uint32_t, 2>> edge;  ///< the shared vertices, parallel to neighbor
};
FaceGraph BuildFaceGraph(const Shape& mesh);

/// Vertices joined by an edge.
struct VertexGraph {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> neighbor;
  std::vector<double> length;  ///< of the edge
};
/// Of a mesh: its edges. Of a cloud: each point with its `cloud_neighbors` nearest, made symmetric.
/// Pieces that nothing joins stay apart.
VertexGraph BuildVertexGraph(const Shape& shape, int cloud_neighbors = 8);

/// What a method found: one label an element, 0 .. parts-1; with a core, it is 0.
struct Segmentation {
  std::vector<std::int32_t> label;
  int parts = 0;
  bool has_core = false;
  std::string note;  ///< what the user should know (centre moved, one part, ...), empty if nothing
};

/// Labels of the input's elements: those left out get the label of the nearest element that was
/// kept.
std::vector<std::int32_t> LabelsOfInput(const Shape& shape, const geometry::TriangleMesh& input,
                                        const Segmentation& segmentation);

}  // namespace rangegrasp::parts
