#pragma once

#include <optional>
#include <string_view>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// The volume of water that a surface holds when a direction points up, by priority flooding of its
/// upper side (Barnes et al. 2014): over each cell of a grid water stands as high as the lowest rim
/// on the way out. What is unseen within a rim is as deep as the deepest that is seen.
/// @param points  of the surface, no more apart than a cell: its extent across / `cells`
/// O(n + cells^2 log cells).
double HeldWater(geometry::PointSpan points, const Eigen::Vector3d& up, int cells = 24);

/// What a part is for (the purpose of chapter 6).
enum class PartFunction { kContainer, kHandle, kOther };
constexpr std::array<std::string_view, 3> WordsOf(PartFunction) {
  return {"container", "handle", "other"};
}

/// Another part that borders on one.
struct PartNeighbor {
  std::int32_t label = 0;
  double border = 0.0;  ///< mesh: length of the shared edges; cloud: 0
  int joints = 0;       ///< places, apart from each other, where they meet
};

/// A part as someone who grasps by parts wants it. Lengths are in the shape's unit.
struct PartDescription {
  std::int32_t label = 0;
  double area = 0.0;                    ///< of a mesh; of a cloud 0
  std::optional<double> volume;         ///< of a part that closes a volume by itself
  Eigen::Vector3d center;               ///< center of gravity of the surface, or of the points
  Eigen::Matrix3d axes;                 ///< columns: principal directions, longest extent first
  Eigen::Vector3d extents;              ///< along these
  std::vector<PartNeighbor> neighbors;  ///< ascending labels
  double holds = 0.0;  ///< volume of water that it holds at most, however it is turned
  PartFunction function = PartFunction::kOther;
};

struct FunctionOptions {
  /// A container holds this share of its convex hull's volume or more. Mugs and bowls hold half
  /// and more; what collects on an animal's back is some hundredths.
  double min_held = 0.25;
  /// A handle stands out of the container's hull: half of it and more by this share of the
  /// container's smallest extent. Crumbs of the rim and wall lie in the hull or at it.
  double min_out = 0.06;
  /// It is thin: its smallest extent is at most this share of the container's.
  double max_thickness = 0.5;
  /// And light: at most this share of the container's elements.
  double max_share = 0.5;
  /// One view may show no inside and hide the ends of a handle: where no part is a container the
  /// largest is what handles stand out of, and they need not be joined to it.
  bool one_view = false;
  /// Directions that water is poured against, in addition to the part's own axes: a seen side has
  /// others.
  std::vector<Eigen::Vector3d> up;
};

/// Describes each part. The container is the part that holds most; a handle is thin, stands out of
/// the container and is joined to it twice; in a cloud, of which a side may be unseen, once.
/// O(n log n).
std::vector<PartDescription> DescribeParts(const Shape& shape, const Segmentation& segmentation,
                                           const FunctionOptions& options = {});

}  // namespace rangegrasp::parts
