#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "parts/shape.h"

namespace rangegrasp::parts {

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};
/// The exact smallest enclosing sphere (Gaertner 1999; CGAL). @throws std::invalid_argument without
/// points.
Sphere SmallestEnclosingSphere(geometry::PointSpan points);
/// R of eq. 6.1 round a given centre.
double BoundingRadius(geometry::PointSpan points, const Eigen::Vector3d& center);

/// Eq. 6.2: outside of the sphere, as far as p was inside of it. A point in the centre goes along
/// +x.
Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere);
/// Eq. 6.5 with the sign that brings a mirrored point back: to its own radius plus 2 * offset.
Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset);
/// Eq. 6.4 (cloud: neighbours nearer than d_max, the largest of all nearest-neighbour distances)
/// and 6.7 (mesh: vertices joined by an edge): the mean of | |p_n - C| - |p - C| |; 0 without
/// neighbours.
double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center);

/// Whether a point is inside a shape. Mesh: generalised winding number (Jacobson et al. 2013) of at
/// least one half, with its pieces turned outwards first, so that open, self-intersecting and badly
/// oriented meshes have an answer too. Cloud: points lie in at least half of all directions from
/// it.
bool IsInside(const Shape& shape, const Eigen::Vector3d& p);

struct MirrorOptions {
  bool go_on_outside =
      false;  ///< segment although no centre inside was found (as in the chapter's evaluation)
};

/// The core: elements inside the inner hull (eq. 6.2-6.6). A face is inside if all of its vertices
/// are.
struct Core {
  Eigen::Vector3d center;
  bool center_inside = true;
  bool used_centroid = false;  ///< the smallest sphere's centre was outside of the shape
  std::vector<std::uint32_t> hull_points;  ///< points whose images lie on the outer hull, ascending
  std::vector<bool> inside;                ///< one a point
};
/// Centre: of the smallest enclosing sphere, else the centre of gravity; nullopt if neither is
/// inside and options do not go on.
std::optional<Core> ExtractCore(const Shape& shape, const MirrorOptions& options);

/// The chapter's method (section 6.2): core, then the rest by flood filling (cloud: distance d_a,
/// eq. 6.8) or face connectivity; parts from 1 by falling size. Invariant under rotation,
/// translation and scale; no thresholds. O(n log n). d_a is the mean distance of the remaining
/// points to the last of their eight nearest: to the nearest one alone, as eq. 6.8 may be read,
/// half of all points would be farther than the mean. Points that are among each other's eight
/// nearest belong together too, since a scan is not equally dense everywhere. Pieces of no more
/// than eight points go to the nearest part.
/// @throws core::InputError if no centre inside can be found and options do not go on.
Segmentation SegmentByMirroring(const Shape& shape, const MirrorOptions& options);

}  // namespace rangegrasp::parts
