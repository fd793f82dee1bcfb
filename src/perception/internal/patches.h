#pragma once

#include <cstdint>
#include <vector>

#include "geometry/adjacency.h"
#include "geometry/point_cloud.h"
#include "perception/segment.h"

namespace rangegrasp::perception::internal {

/// Which points are neighbors on a surface: of each those that it has, ascending. Symmetric.
using Links = geometry::Adjacency;

/// Points within link_m; and where a surface is seen at a grazing angle, so that there are few of
/// them, points further off that lie in each other's tangent planes.
Links FindLinks(const geometry::PointCloud& cloud, const ConvexityOptions& options);

/// A piece of surface that is small and nearly flat.
struct Patch {
  std::uint32_t points = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< unit, as the points' normals
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();   ///< sum of d d^T, d from the center [m^2]
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero();  ///< sum of (n - normal) d^T [m]

  /// How fast its normals turn along a direction [rad/m], by least squares: > 0 where it is convex
  /// that way.
  double TurningAlong(const Eigen::Vector3d& direction) const {
    const double length = direction.dot(spread * direction);
    return length > 0.0 ? direction.dot(turning * direction) / length : 0.0;
  }
};
struct Patches {
  std::vector<Patch> patches;
  std::vector<std::uint32_t> patch_of;  ///< one a point
};

/// Takes a surface apart into patches of about patch_m that do not bend: grown along the links from
/// seeds that are spread evenly over the surface and the directions it faces, nearest first, by
/// distance and normal (simple non-iterative clustering: Achanta and Suesstrunk 2017). Every patch
/// hangs together. O(m log m), m links.
Patches GrowPatches(const geometry::PointCloud& cloud, const Links& links,
                    const ConvexityOptions& options);

}  // namespace rangegrasp::perception::internal
