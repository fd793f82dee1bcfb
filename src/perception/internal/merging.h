#pragma once

#include "perception/internal/objects.h"

namespace rangegrasp::perception::internal {

/// How near other points come to a part. The tree is built for the first point that comes close,
/// because most parts are far from each other.
class PartSurface {
 public:
  explicit PartSurface(Points points_C);
  PartSurface(const PartSurface&) = delete;  // the tree keeps a view of the points
  PartSurface& operator=(const PartSurface&) = delete;

  /// The part's point nearest to p; nullopt if it is further than gap_m [m] away.
  std::optional<std::uint32_t> NearestWithin(const Vector3d& p_C, double gap_m);
  /// All points of the part within gap_m of p, by position in the part; valid until the next call.
  std::span<const geometry::KdTree::Neighbor> Within(const Vector3d& p_C, double gap_m);

 private:
  Points points_C_;
  Eigen::AlignedBox3d box_;
  std::optional<geometry::KdTree> tree_;
  std::vector<geometry::KdTree::Neighbor> nearest_;
};

/// The reason why two parts are one object.
enum class Kinship {
  kNone,
  kWithin,   ///< in a rotational host (a vessel's floor, far wall), or a crumb under a host's top
  kCap,      ///< a small part at the host's end, in line with it: the cap or neck of a bottle
  kSurface,  ///< the host's surface continues across a gap in the sensor's direction
  kHanging,  ///< it touches the host and nothing else, in the air: a handle
};

/// Whether `fragment` is a part of the same object as `host`, by these rules (the shares and
/// lengths are MergeOptions):
/// - kWithin: 70 % of its points are over the footprint of a standing rotational host and not above
///   its top, or inside a lying one. With any host: it is under the host's top in the same way, has
///   at most 5 % of the host's points, and one of its own is within the gap.
/// - kCap: at least eight points are within the gap from the host. Along the table's normal, or
///   either way along the principal axis of the host's top surface, it begins where the host ends,
///   is at most 0.45 times as long, and 80 % of its points are over the host's cross-section.
///   Across the view it is at most 0.7 times as wide, and off its middle by at most 0.15 of that.
///   Bottles need not be round; a thing that lies on another is in line with it only by chance.
/// - kSurface: at least eight points, and about as many as the fragment is wide (the square root of
///   its number of points), have their nearest neighbor in the host across the gap, more along the
///   sensor's viewing plane than sideways, and neither surface lies in front of the other's tangent
///   plane (smooth or convex, unlike objects in contact); unless the segmentation cut there.
/// - kHanging, if the segmentation cuts: at least eight points are within the gap from the host,
///   which has five times as many points; it is off the table, the sensor saw through under a good
///   part of it, and the host does not carry it from below.
Kinship FindKinship(const ObjectContext& context, const Part& fragment, const Part& host);

/// Joins fragments to hosts by FindKinship, fragments with fewer points first, until nothing
/// changes, and describes the unions.
void MergeFragments(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng);

/// Joins parts that touch each other and nothing else, if together they are no larger than a hand
/// can hold (MergeOptions: their height, and the rectangle around them on the table) and no two of
/// them meet at a sharp concave edge. Objects that stand together are usually larger; if they are
/// not, a grasp disambiguates the situation (section 5.6).
void MergeLone(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng);

/// Merges clipped rotational parts (section 5.1.3, eq. 5.6 to 5.8) in pairs until nothing changes.
/// Two parts become one if the union is rotational (so at least the body share of all points of
/// both agrees with their sections), at least the rim share of each part's rim points lies on its
/// circle, and at least half of each part's body agrees. The union takes the first part's place.
void MergeRotational(const ObjectContext& context, std::vector<Part>& parts, base::Rng& rng);

}  // namespace rangegrasp::perception::internal
