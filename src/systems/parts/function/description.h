#pragma once

#include <string_view>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Volume of water that a surface holds when `up` points up, by priority flooding of its upper side
/// (Barnes et al. 2014). Over each cell of a grid the water is as high as the lowest rim on the way
/// out. Unseen cells within a rim are assumed to be as deep as the deepest seen one. O(n + cells^2
/// log cells).
/// @param points  of the surface, at most one cell apart; a cell is 1/24 of the extent across
double HeldWater(geometry::PointSpan points, const Eigen::Vector3d& up);

/// The function of a part (the purpose of chapter 6).
enum class PartFunction { kContainer, kHandle, kOther };
constexpr std::array<std::string_view, 3> WordsOf(PartFunction) {
  return {"container", "handle", "other"};
}

/// A part that borders on another one.
struct PartNeighbor {
  std::int32_t label = 0;
  double border = 0.0;  ///< mesh: length of the shared edges; cloud: 0
  int joints = 0;       ///< number of separate places where they meet
};

/// Description of a part for grasping. Lengths are in the shape's unit.
struct PartDescription {
  std::int32_t label = 0;
  double area = 0.0;                    ///< mesh: surface area; cloud: 0
  Eigen::Vector3d center;               ///< center of gravity of the surface, or of the points
  Eigen::Matrix3d axes;                 ///< columns: principal directions, longest extent first
  Eigen::Vector3d extents;              ///< extents along these axes
  std::vector<PartNeighbor> neighbors;  ///< in ascending order of labels
  double holds = 0.0;  ///< maximum volume of water that it holds, over all tested orientations
  PartFunction function = PartFunction::kOther;
};

struct FunctionOptions {
  /// A container holds at least this fraction of the volume of its convex hull. Mugs and bowls hold
  /// half or more; what collects on an animal's back is a few hundredths.
  double min_held = 0.25;
  /// A handle protrudes from the container's hull: at least half of it is outside by this fraction
  /// of the container's smallest extent. Small pieces of the rim and wall lie in the hull or on it.
  double min_out = 0.06;
  /// A handle is thin: its smallest extent is at most this fraction of the container's.
  double max_thickness = 0.5;
  /// A handle is small: it has at most this fraction of the container's elements.
  double max_share = 0.5;
  /// Set for a single view, which may hide the inside and the ends of a handle. If no part is a
  /// container, handles protrude from the largest part. They need not be joined to it.
  bool one_view = false;
  /// Up directions for testing what a part holds, in addition to its own axes, which differ if only
  /// one side is seen.
  std::vector<Eigen::Vector3d> up;
};

/// Describes each part. The container is the part that holds most. A handle is thin, protrudes from
/// the container and is joined to it in two places, or in one for a cloud, of which a side may be
/// unseen. O(n log n).
std::vector<PartDescription> DescribeParts(const Shape& shape, const Segmentation& segmentation,
                                           const FunctionOptions& options = {});

}  // namespace rangegrasp::parts
