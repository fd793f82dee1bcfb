#pragma once

#include <optional>
#include <vector>

#include "core/rng.h"
#include "perception/feature_options.h"
#include "perception/scene.h"
#include "perception/sensor_view.h"

namespace rangegrasp::perception {

/// A part on its way to an object: one segment or several joined, and what was found of it.
struct Part {
  geometry::Indices points;  ///< ascending positions in the cloud
  std::optional<TopSurface> top;
  std::optional<RotationAxis> axis;
};

/// What the steps of merging read.
struct MergeContext {
  const geometry::PointCloud& cloud;
  const geometry::Plane& table;
  const Eigen::Vector3d& sensor_C;
  const FeatureOptions& options;
};

/// Top surface and rotation axis of a set of points.
Part DescribePart(const MergeContext& context, geometry::Indices points, core::Rng& rng);

/// Merging of clipped rotational parts (section 5.1.3, eq. 5.6 to 5.8), pairwise until nothing
/// changes: two parts become one if the union is rotational (so at least the body share of all
/// points of both agrees with their sections), at least the rim share of each part's rim points
/// lies on its circle, and at least half of each part's body agrees. The first of the pair keeps
/// its place.
void MergeRotational(const MergeContext& context, std::vector<Part>& parts, core::Rng& rng);

/// Why two parts would be one object.
enum class Kinship {
  kNone,
  kWithin,   ///< the fragment lies in the host's footprint and below its top: a cavity's floor, a
             ///< front face under its top surface
  kAbove,    ///< a small part above the host, over its footprint: the cap of a bottle
  kSurface,  ///< the host's surface goes on across a gap in the sensor's direction
};

/// Whether `fragment` is a part of the same object as `host`, from the options' gap and these
/// rules:
/// - kWithin: 70 % of its points over the host's footprint (grown by 5 mm), not above its top, and
///   no further from its points than the gap, or over a rotational host. A host whose points leave
///   most of its footprint empty (the rim of a large box) holds nothing unless it is rotational.
/// - kAbove: 90 % over the footprint, the lowest point at the host's top within the gap, a
/// footprint
///   of at most 60 % of the host's.
/// - kSurface: at least eight points have their nearest neighbour in the host across the gap, more
///   along the sensor's viewing plane than sideways, and neither surface lies in front of the other
///   one's tangent plane (smooth or convex, as objects in contact are not).
/// Objects beside each other fail all three: their footprints do not overlap and the gap between
/// them runs sideways, or the junction is concave.
Kinship FindKinship(const MergeContext& context, const Part& fragment, const Part& host);

/// Joins fragments to hosts by FindKinship, smallest fragment first, until nothing changes, and
/// describes the unions.
void MergeFragments(const MergeContext& context, std::vector<Part>& parts, core::Rng& rng);

}  // namespace rangegrasp::perception
