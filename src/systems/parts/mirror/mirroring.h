#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Tests whether a point is inside a shape. Mesh: the generalised winding number (Jacobson et al.
/// 2013) is at least one half; pieces are oriented outwards first, so that the test works for any
/// mesh. Cloud: points lie in at least half of all directions from it.
bool IsInside(const Shape& shape, const Eigen::Vector3d& p);

/// The core: elements inside the inner hull (eq. 6.2-6.6). A face is inside if all of its vertices
/// are inside.
struct Core {
  Eigen::Vector3d center;
  bool center_inside = true;
  bool used_centroid = false;  ///< the smallest sphere's center was outside the shape
  std::vector<bool> inside;    ///< one per point
};
/// The center is that of the smallest enclosing sphere, or else the center of gravity. nullopt if
/// neither is inside and `go_on_outside` is not set.
std::optional<Core> ExtractCore(const Shape& shape, bool go_on_outside = false);

/// The chapter's method (section 6.2): the core, then the rest by face connectivity or, for a
/// cloud, by flood filling (distance d_a, eq. 6.8); parts from 1 by decreasing size. Invariant
/// under rotation, translation and scale; no thresholds. O(n log n). d_a is the mean distance to
/// the eighth nearest remaining point. With the nearest one only, as eq. 6.8 may be read, half of
/// all points would be farther. Points among each other's eight nearest also belong together, since
/// scans have uneven density. Pieces of up to eight points go to the nearest part. For a noisy
/// cloud PointsOfSurface is segmented, because noise would affect eq. 6.4 and 6.8.
/// @param go_on_outside  segment even if no center inside was found (as in the chapter's
/// evaluation)
/// @throws base::InputError if no center inside can be found and `go_on_outside` is not set.
Segmentation SegmentByMirroring(const Shape& shape, bool go_on_outside = false);

}  // namespace rangegrasp::parts
