#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The neighbors of each point within one radius, where they were searched for anyway: a second
/// pass over them need not search again.
struct NeighborLists {
  /// 64 MB. Of a cloud with more of them in all the last points' lists are not kept.
  static constexpr std::size_t kMaxKept = std::size_t{1} << 24;

  double radius_m = 0.0;
  std::vector<std::size_t> ends;  ///< one a point whose list is kept: where it ends in `all`
  Indices all;

  bool Has(std::size_t i) const { return i < ends.size(); }
  std::span<const std::uint32_t> Of(std::size_t i) const {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return {all.data() + first, ends[i] - first};
  }
};

/// Unit normals by principal components of the points within radius_m (section 4.2.2,
/// eq. 4.10-4.12), turned to the side of the place that the point was seen from. A point with fewer
/// than three neighbors takes the normal of its nearest three.
/// @param places  where the sensors stood
/// @param place_of  one a point: position in places
/// @param max_radius_m  a neighborhood that lies on a line (of a line scanner, on a face that it
/// sees at a grazing angle) says nothing across it, and is widened up to this; 0: as published.
/// @param kept  receives the neighbors within radius_m, each point among its own; may be null
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of, double max_radius_m = 0.0,
                       NeighborLists* kept = nullptr);
/// The same where all points were seen from one place.
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m,
                       const Eigen::Vector3d& origin);

/// Unit normals of the faces of a mesh (section 5.1.3): each triangle's turned to the side of the
/// place that a point was seen from, and a point's the mean of those that it is a corner of,
/// weighted by their areas. A point of no triangle faces the place that it was seen from.
/// @param triangles  positions in points
Points FaceNormals(PointSpan points, std::span<const std::array<std::uint32_t, 3>> triangles,
                   PointSpan places, std::span<const std::uint32_t> place_of);

}  // namespace rangegrasp::geometry
