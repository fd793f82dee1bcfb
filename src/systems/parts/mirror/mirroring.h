#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Whether a point is inside a shape. Mesh: generalised winding number (Jacobson et al. 2013) of at
/// least one half, its pieces turned outwards first, so that any mesh has an answer. Cloud: points
/// lie in at least half of all directions from it.
bool IsInside(const Shape& shape, const Eigen::Vector3d& p);

struct MirrorOptions {
  /// Segment although no center inside was found (as in the chapter's evaluation).
  bool go_on_outside = false;
};

/// The core: elements inside the inner hull (eq. 6.2-6.6). A face is inside if all of its vertices
/// are.
struct Core {
  Eigen::Vector3d center;
  bool center_inside = true;
  bool used_centroid = false;  ///< the smallest sphere's center was outside of the shape
  Indices hull_points;         ///< points whose images lie on the outer hull, ascending
  std::vector<bool> inside;    ///< one a point
};
/// Center: of the smallest enclosing sphere, else the center of gravity; nullopt if neither is
/// inside and options do not go on.
std::optional<Core> ExtractCore(const Shape& shape, const MirrorOptions& options);

/// The chapter's method (section 6.2): core, then the rest by face connectivity or, of a cloud,
/// flood filling (distance d_a, eq. 6.8); parts from 1 by falling size. Invariant under rotation,
/// translation and scale; no thresholds. O(n log n). d_a is the mean distance to the last of eight
/// nearest remaining points: of the nearest alone, as eq. 6.8 may be read, half of all are farther.
/// Points among each other's eight nearest belong together too, since scans are unevenly dense;
/// pieces of up to eight points go to the nearest part. Of a noisy cloud PointsOfSurface are
/// segmented: noise would count in eq. 6.4 and 6.8.
/// @throws base::InputError if no center inside can be found and options do not go on.
Segmentation SegmentByMirroring(const Shape& shape, const MirrorOptions& options);

}  // namespace rangegrasp::parts
