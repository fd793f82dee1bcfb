#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cylinders/axis_fit.h"
#include "geometry/point_cloud.h"

/// Whether what was seen agrees with a cylinder that would stand there.
namespace rangegrasp::cylinders {

/// Where the ray from `origin` to `target` first meets the closed cylinder, as a share of the way
/// to the target (so above 1 behind it); nullopt if it misses it or starts inside.
struct Entry {
  double share = 0.0;
  bool by_end = false;  ///< through an end, not through the barrel
};
std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& target,
                             const Cylinder& cylinder);

/// Measured points by what their ray says of a cylinder.
struct ViewCounts {
  std::size_t on = 0;       ///< the point is on its surface
  std::size_t before = 0;   ///< something in front hides it there
  std::size_t through = 0;  ///< the ray went through where the cylinder would be: it is not there

  std::size_t All() const { return on + before + through; }
  /// Share of the rays not hidden that agree; 0 if there are none.
  double Agreement() const {
    const std::size_t seen = on + through;
    return seen == 0 ? 0.0 : static_cast<double>(on) / static_cast<double>(seen);
  }
};

/// Compares every ray that meets the cylinder with where it should have ended. A ray that enters by
/// an end and ends inside says nothing: a cup is open. O(n).
/// @param places  where the sensor stood; place_of: one a point
/// @param tolerance_m  the ray counts as through only if it meets a cylinder smaller by this all
/// round (and not lower than half of it)
/// @param left_out  where not empty, one a point: whether its ray is left out
ViewCounts CompareWithView(geometry::PointSpan points, geometry::PointSpan places,
                           std::span<const std::uint32_t> place_of, const Cylinder& cylinder,
                           double tolerance_m, const std::vector<bool>& left_out = {});

/// For each point whether it is on the surface of the closed cylinder, to within the tolerance.
/// O(n).
std::vector<bool> PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m);

}  // namespace rangegrasp::cylinders
