#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
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

/// A mesh or a point cloud that is finite, without duplicate or unused points. Its elements, which
/// get labels, are the faces of a mesh and the points of a cloud.
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

/// The unit vector of height z that is the k-th of a spiral by the golden angle: with evenly rising
/// z these are spread evenly over the sphere.
Eigen::Vector3d SpiralDirection(int k, double z);

/// Of an edge, or between any two points.
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

/// 0 .. count - 1 by rising key(i), ties by number.
template <typename Key>
Indices OrderBy(std::size_t count, const Key& key) {
  Indices order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, key);
  return order;
}

/// The sum of the weights in each of `count` groups.
std::vector<double> GroupSums(const Labels& group, const std::vector<double>& weight,
                              std::size_t count);

/// Renumbers faces so that they use only vertices that stand in the result, ascending positions.
Indices UseOnly(std::size_t vertices, std::vector<Face>& faces);

/// Cleans a mesh or (without triangles) a cloud.
/// @throws base::InputError for fewer than 4 finite points, all points in a plane, no face left.
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
FaceFrames GroupFrames(const FaceFrames& faces, const Labels& group, std::size_t count);

/// How far points stand out of a convex hull [its unit]: the largest distance to the plane of one
/// of its triangles, negative inside. O(points * triangles).
std::vector<double> HeightsAbove(const geometry::TriangleMesh& hull, const Points& points);

/// A mesh in a frame of its own: its surface has area 1 and its center of gravity at the origin,
/// its axes of inertia are x, y, z by falling extent, pointing where the surface is skewed to;
/// vertices and faces stand in the order of their coordinates.
///
/// Bytes are the same for any order of vertices and faces and any turn, shift and scale: rounding
/// is cut off. Only where extents or skews are equal to the last digits (a turn or mirroring maps
/// the shape onto itself) axes may change places. Faces cut in smaller ones do not move the axes.
struct CanonicalMesh {
  Shape mesh;
  Indices origin;  ///< of each face: its number in the input
};
/// O(n log n)
CanonicalMesh MakeCanonical(const Shape& mesh);

/// The same for a cloud: its middle is the origin, the mean square distance from it 1. O(n log n)
struct CanonicalCloud {
  Points points;
  Indices origin;  ///< of each point: its number in the input
};
CanonicalCloud MakeCanonicalCloud(const Points& points);

}  // namespace rangegrasp::parts
