#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// Nearest-neighbor and radius queries (a kd-tree, Bentley 1975; nanoflann). Keeps a view of the
/// points: they must outlive the tree and not move. Queries are const and may run in parallel.
class KdTree {
 public:
  struct Neighbor {
    std::uint32_t index;
    double squared_distance;  ///< [m^2]
  };

  /// O(n log n). Points must be finite.
  /// @throws std::invalid_argument if a point is not finite.
  explicit KdTree(PointSpan points);

  /// The k points nearest to the query, ascending by distance (fewer if fewer have distance <=
  /// max_m [m]). A query that is itself a point of the tree finds itself first.
  void Nearest(const Eigen::Vector3d& query, std::size_t k, std::vector<Neighbor>& out,
               double max_m = std::numeric_limits<double>::infinity()) const;
  /// All points with distance < radius [m], unsorted.
  void Within(const Eigen::Vector3d& query, double radius_m, std::vector<Neighbor>& out) const;
  /// How many points have distance < radius [m]; counting stops at `limit`.
  std::size_t CountWithin(const Eigen::Vector3d& query, double radius_m,
                          std::size_t limit = static_cast<std::size_t>(-1)) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Distances of points to their nearest other one (section 5.1.2: d_max, d_a; eq. 4.5-4.6).
struct NeighborDistances {
  std::vector<double> each_m;
  double max_m = 0.0;
  double mean_m = 0.0;  ///< d_k, eq. 4.6
};
/// Needs at least two points. @throws std::invalid_argument otherwise.
NeighborDistances NearestNeighborDistances(PointSpan points, const KdTree& tree);

/// Connected groups of points, each within link_m [m] of another point of its group; in the order
/// of their first points. Points keep their order. O(n log n) for few neighbors per point.
/// @throws std::invalid_argument if a point is not finite.
std::vector<Points> GroupsWithin(const Points& points, double link_m);

/// The same as indices, with a tree over these points.
std::vector<Indices> GroupsWithin(PointSpan points, const KdTree& tree, double link_m);

}  // namespace rangegrasp::geometry
