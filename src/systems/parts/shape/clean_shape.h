#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
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

/// Finite, and not so large that its squares overflow.
bool IsUsable(const Eigen::Vector3d& p);

/// Cleans a mesh or (without triangles) a cloud.
/// @throws base::InputError saying what is wrong: fewer than 4 finite points, all points in a
/// plane, no face left.
Shape MakeShape(const geometry::TriangleMesh& mesh);

}  // namespace rangegrasp::parts
