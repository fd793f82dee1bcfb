#pragma once

#include "parts/mirror/mirroring.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {

/// What protrudes from a core, per element (faces of a mesh, points of a cloud).
struct StandingOut {
  std::vector<double> growth;  ///< growth of the core's hull that includes it; <= 1: in the core
  std::vector<double> weight;  ///< area of a face, or 1
  std::vector<double> remoteness;  ///< mean geodesic distance to the whole shape
  /// Neighbors of element i are neighbor[begin[i] .. begin[i + 1]).
  Indices begin, neighbor;
};

struct LimbOptions {
  double min_weight = 0.01;  ///< minimum share of all weight for a limb; less is a crumb
  /// A limb persists while the core grows by this fraction of itself; less is a bump.
  double min_prominence = 0.1;
  /// Minimum ratio of the remoteness of its tip and its root. On the four models used for tuning,
  /// limbs, tails and ears have 1.26 and more, bellies, udders and bent hips 1.14 and less.
  double min_reach = 1.2;
};

/// Cuts protrusions into limbs.
///
/// As the core grows, the pieces outside of it shrink, split and vanish, which gives a tree (the
/// join tree of `growth`). A piece is one limb or is replaced by the pieces that it splits into,
/// whichever last for a longer growth of the core; for the latter the mean counts. A chest with
/// arms and head is split, an arm with fingers stays whole. Each limb is thus cut where it joins
/// others. A limb leads away from the rest (the feature points of Katz et al. 2005); other pieces
/// belong to the core. A piece is split only if two of its limbs lead away: a head with short ears
/// stays whole. O(n log n).
/// @return one label per element: 0 for the core, from 1 for the limbs by decreasing weight.
Labels LabelLimbs(const StandingOut& elements, const LimbOptions& options);

struct PoseInvariantOptions {
  int landmarks = 400;  ///< >= 4; shapes with fewer points use all of them
  SmacofOptions smacof{};
  /// An embedding intersects itself, so that a center outside of it says nothing about the shape.
  MirrorOptions mirror{.go_on_outside = true};
  bool grow_core = true;  ///< false: as in the chapter
  LimbOptions limbs{};
};
/// The pose-invariant form of a shape (section 6.2.3). Landmarks are embedded by SMACOF; other
/// points are placed by their geodesic distances to them. Elements stay the same, positions change.
Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options);
/// Segments the pose-invariant form by mirroring; the labels apply to the shape. Beyond the
/// chapter, the core's hull grows until limbs separate, each where it joins others (LabelLimbs).
/// @throws whatever SegmentByMirroring throws.
Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options);

}  // namespace rangegrasp::parts
