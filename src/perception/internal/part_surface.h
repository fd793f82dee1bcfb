#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/kd_tree.h"

namespace rangegrasp::perception::internal {

/// The points of a part, to be asked how near other points come. The tree is built for the first
/// point that comes close: most parts are far from each other.
class PartSurface {
 public:
  explicit PartSurface(geometry::Points points_C);
  PartSurface(const PartSurface&) = delete;  // the tree keeps a view of the points
  PartSurface& operator=(const PartSurface&) = delete;

  /// Which of the part's points is the nearest to p; nullopt if that is further than gap_m [m] off.
  std::optional<std::uint32_t> NearestWithin(const Eigen::Vector3d& p_C, double gap_m);

 private:
  geometry::Points points_C_;
  Eigen::AlignedBox3d box_;
  std::optional<geometry::KdTree> tree_;
  std::vector<geometry::KdTree::Neighbor> nearest_;
};

}  // namespace rangegrasp::perception::internal
