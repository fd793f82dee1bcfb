#pragma once

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// What protrudes from a core, per element (faces of a mesh, points of a cloud).
struct StandingOut {
  std::vector<double> growth;  ///< growth of the core's hull that includes it; <= 1: in the core
  std::vector<double> weight;  ///< area of a face, or 1
  std::vector<double> remoteness;  ///< mean geodesic distance to the whole shape
  /// Neighbors of element i are neighbor[begin[i] .. begin[i + 1]).
  Indices begin, neighbor;
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
Labels LabelLimbs(const StandingOut& elements);

/// More landmarks embed a shape more exactly, at quadratic cost.
inline constexpr int kFormLandmarks = 400;
/// The pose-invariant form of a shape.
struct PoseInvariantForm {
  Shape shape;                     ///< the same elements at other positions
  std::vector<double> remoteness;  ///< per point: mean geodesic distance to the landmarks
};
/// Section 6.2.3: landmarks are embedded by SMACOF; other points are placed by their geodesic
/// distances to them.
/// @param landmarks  >= 4; shapes with fewer points use all of them
PoseInvariantForm PoseInvariant(const Shape& shape, int landmarks = kFormLandmarks);
/// Segments the pose-invariant form by mirroring; the labels apply to the shape. Beyond the
/// chapter, the core's hull grows until limbs separate, each where it joins others (LabelLimbs).
Segmentation SegmentPoseInvariant(const Shape& shape);

}  // namespace rangegrasp::parts
