#pragma once

#include <cstdint>
#include <vector>

#include "geometry/point_cloud.h"
#include "perception/segment.h"

namespace rangegrasp::perception::internal {

/// Which points are neighbors on a surface: those of point i are in `to` from first[i] to
/// first[i + 1]. Symmetric.
struct Links {
  std::vector<std::uint32_t> first;
  geometry::Indices to;

  std::span<const std::uint32_t> Of(std::uint32_t i) const {
    return std::span(to).subspan(first[i], first[i + 1] - first[i]);
  }
};

/// Points within link_m; and where a surface is seen at a grazing angle, so that there are few of
/// them, points further off that lie in each other's tangent planes.
Links FindLinks(const geometry::PointCloud& cloud, const ConvexityOptions& options);

/// A piece of surface that is small and nearly flat.
struct Patch {
  std::uint32_t points = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, as the points' normals
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
