#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

using geometry::Indices;
using geometry::Points;
using Face = std::array<std::uint32_t, 3>;  ///< a triangle by its vertices
using Edge = std::array<std::uint32_t, 2>;  ///< two vertices
using Labels = std::vector<std::int32_t>;   ///< one an element

/// A mesh or a point cloud made ready for segmentation: finite, without duplicate or unused points.
/// Elements are what gets a label: the faces of a mesh, the points of a cloud.
struct Shape {
  Points points;            ///< vertices or points [any unit]
  std::vector<Face> faces;  ///< empty: a cloud
  /// For each element of the input the element here, -1 where it was left out (not finite, out of
  /// range, without area); a point of a cloud that stands twice maps to the one that is kept.
  Labels element_of_input;

  bool IsMesh() const { return !faces.empty(); }
  std::size_t Elements() const { return IsMesh() ? faces.size() : points.size(); }
};

/// Finite, and not so large that its squares overflow.
bool IsUsable(const Eigen::Vector3d& p);

/// For the order of points by their coordinates.
inline auto CoordinatesOf(const Eigen::Vector3d& p) { return std::tie(p.x(), p.y(), p.z()); }

/// Cleans a mesh or (without triangles) a cloud.
/// @throws base::InputError saying what is wrong: fewer than 4 finite points, all points in a
/// plane, no face left.
Shape MakeShape(const geometry::TriangleMesh& mesh);

/// Each face of a mesh.
struct FaceFrames {
  Points center;  ///< mean of the corners
  Points normal;  ///< unit
  std::vector<double> area;
  double total_area = 0.0;
};
FaceFrames BuildFaceFrames(const Shape& mesh);
/// The same of `count` groups of faces: middle of the surface, and unit mean normal or zero.
/// @param group  of each face, from 0
FaceFrames GroupFrames(const FaceFrames& faces, const Labels& group, std::size_t count);

/// How far points stand out of a convex hull [its unit]: the largest distance to the plane of one
/// of its triangles, negative inside. O(points * triangles).
std::vector<double> HeightsAbove(const geometry::TriangleMesh& hull, const Points& points);

/// A mesh as it would be whatever way it lay and was written down: its surface has area 1 and its
/// center of gravity at the origin, its axes of inertia are x, y, z by falling extent, pointing
/// where the surface is skewed to, and vertices and faces stand in the order of their coordinates.
///
/// Bytes are the same for any order of vertices and faces. For any turn, shift and scale they are
/// the same up to rounding, which is cut off; only of a shape whose extents or skews are equal to
/// the last digits, one that a turn or mirroring maps onto itself, the axes may change places.
/// Faces cut in smaller ones do not move the axes, which are of the surface, not of its vertices.
struct CanonicalMesh {
  Shape mesh;
  Indices origin;  ///< of each face: its number in the input
};
/// O(n log n)
CanonicalMesh MakeCanonical(const Shape& mesh);

/// The same for a cloud, each of whose points counts as much as the others: its middle is the
/// origin, the mean square distance from it 1. O(n log n)
struct CanonicalCloud {
  Points points;
  Indices origin;  ///< of each point: its number in the input
};
CanonicalCloud MakeCanonicalCloud(const Points& points);

}  // namespace rangegrasp::parts
