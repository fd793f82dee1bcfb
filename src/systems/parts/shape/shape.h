#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

using geometry::Indices;
using geometry::Points;
using Face = std::array<std::uint32_t, 3>;  ///< the vertices of a triangle
using Edge = std::array<std::uint32_t, 2>;  ///< two vertices
using Labels = std::vector<std::int32_t>;   ///< one per element

/// A finite mesh or point cloud without duplicate or unused points. Its elements, which get labels,
/// are the faces of a mesh or the points of a cloud.
struct Shape {
  Points points;            ///< vertices or points [any unit]
  std::vector<Face> faces;  ///< empty for a cloud
  /// For each element of the input the element here, -1 if it was left out (not finite, out of
  /// range, without area). Duplicate points of a cloud map to the one that is kept.
  Labels element_of_input;

  bool IsMesh() const { return !faces.empty(); }
  std::size_t Elements() const { return IsMesh() ? faces.size() : points.size(); }
};

/// True if p is finite and small enough that its squares do not overflow.
bool IsUsable(const Eigen::Vector3d& p);

/// Key for sorting points by their coordinates.
inline auto CoordinatesOf(const Eigen::Vector3d& p) { return std::tie(p.x(), p.y(), p.z()); }

/// The k-th unit vector of a golden-angle spiral, with height z. With evenly increasing z these are
/// spread evenly over the sphere.
Eigen::Vector3d SpiralDirection(int k, double z);

/// Length of an edge, or distance between any two points.
inline double LengthOf(const Points& points, const Edge& ends) {
  return (points[ends[0]] - points[ends[1]]).norm();
}

/// The edges of a face, each with its lower vertex first.
inline std::array<Edge, 3> EdgesOf(const Face& face) {
  const auto edge = [](std::uint32_t a, std::uint32_t b) {
    return Edge{std::min(a, b), std::max(a, b)};
  };
  return {edge(face[0], face[1]), edge(face[1], face[2]), edge(face[2], face[0])};
}

/// values[where[0]], values[where[1]], ...
template <typename Values, typename Where>
std::vector<typename Values::value_type> ValuesAt(const Values& values, const Where& where) {
  std::vector<typename Values::value_type> found;
  for (const auto i : where) found.push_back(values[i]);
  return found;
}

/// The sum of the weights in each of `count` groups.
std::vector<double> GroupSums(const Labels& group, const std::vector<double>& weight,
                              std::size_t count);

/// Renumbers the faces to use only the vertices in the result, which are in ascending order.
Indices UseOnly(std::size_t vertices, std::vector<Face>& faces);

/// Cleans a mesh or (without triangles) a cloud.
/// @throws base::InputError for fewer than 4 finite points, coplanar points, or no remaining face.
Shape MakeShape(const geometry::TriangleMesh& mesh);

/// Geometry of each face of a mesh.
struct FaceFrames {
  Points center;  ///< mean of the corners
  Points normal;  ///< unit vectors
  std::vector<double> area;
  double total_area = 0.0;
};
FaceFrames BuildFaceFrames(const Shape& mesh);
/// The same for `count` groups of faces: center of the surface, and unit mean normal or zero.
FaceFrames GroupFrames(const FaceFrames& faces, const Labels& group, std::size_t count);

/// Heights of points above a convex hull [its unit]: the largest distance to the plane of one of
/// its triangles, negative inside. O(points * triangles).
std::vector<double> HeightsAbove(const geometry::TriangleMesh& hull, const Points& points);

/// A mesh in its own frame. Its surface has area 1 and its center of gravity is the origin. Its
/// axes of inertia are x, y, z by decreasing extent, in the direction of positive skew. Vertices
/// and faces are sorted by their coordinates.
///
/// The bytes are the same for any order of vertices and faces and any rotation, translation and
/// scale: rounding errors are cut off. Axes may swap only if extents or skews are equal to the last
/// digits (a rotation or reflection maps the shape onto itself). Subdividing faces does not move
/// the axes.
struct CanonicalMesh {
  Shape mesh;
  Indices origin;  ///< per face: its number in the input
};
/// O(n log n)
CanonicalMesh MakeCanonical(const Shape& mesh);

/// The same for a cloud: centroid at the origin, mean square distance from it 1. O(n log n)
struct CanonicalCloud {
  Points points;
  Indices origin;  ///< per point: its number in the input
};
CanonicalCloud MakeCanonicalCloud(const Points& points);

}  // namespace rangegrasp::parts
