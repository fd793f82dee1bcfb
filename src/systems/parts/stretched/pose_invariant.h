#pragma once

#include "parts/mirror/mirroring.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {

/// What stands out of a core, element by element (faces of a mesh, points of a cloud).
struct StandingOut {
  std::vector<double> growth;  ///< the core's hull holds it from this factor on; <= 1: of the core
  std::vector<double> weight;  ///< area, or 1
  std::vector<double> remoteness;  ///< mean geodesic distance to all of the shape
  /// Neighbors of element i are neighbor[begin[i] .. begin[i + 1]).
  Indices begin, neighbor;
};

struct LimbOptions {
  double min_weight = 0.01;  ///< share of all weight from which a piece is a limb, not a crumb
  /// A limb lasts while the core grows by this share of itself: less is a bump.
  double min_prominence = 0.1;
  /// Its tip is so many times as remote as its root. Of limbs, tails and ears of four models that
  /// it was chosen on 1.26 and more, of bellies, udders and bent hips 1.14 and less.
  double min_reach = 1.2;
};

/// Cuts what stands out into limbs.
///
/// As the core grows, the pieces outside of it shrink, fall apart and vanish: a tree (the join tree
/// of `growth`). A piece is one limb or becomes those that it falls into, whichever last for a
/// longer growth of the core, those in the mean: a chest with arms and head falls apart, an arm
/// with fingers stays whole. So each limb is cut where it joins others. A limb leads away from the
/// rest (the feature points of Katz et al. 2005): what does not is the core's, and a piece falls
/// apart only if two of its limbs do: a head with short ears stays whole. O(n log n).
/// @return a label an element: 0 the core, from 1 the limbs by falling weight.
Labels LabelLimbs(const StandingOut& elements, const LimbOptions& options);

struct PoseInvariantOptions {
  int landmarks = 400;  ///< >= 4; shapes with fewer points take all
  SmacofOptions smacof{};
  /// An embedding folds and meets itself: whether its center is inside says nothing of the shape.
  MirrorOptions mirror{.go_on_outside = true};
  bool grow_core = true;  ///< false: as the chapter has it
  LimbOptions limbs{};
};
/// The shape in its pose-invariant form (section 6.2.3): landmarks are embedded by SMACOF, the
/// other points placed from their geodesic distances to them. Same elements, other positions.
Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options);
/// Segments the pose-invariant form by mirroring; the labels hold for the shape. Beyond the
/// chapter: the core's hull grows until limbs come off, each where it joins others (LabelLimbs).
/// @throws what SegmentByMirroring throws.
Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options);

}  // namespace rangegrasp::parts
