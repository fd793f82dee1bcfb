#pragma once

#include "parts/mirror/mirroring.h"
#include "parts/stretched/limbs.h"
#include "parts/stretched/smacof.h"

namespace rangegrasp::parts {

struct PoseInvariantOptions {
  int landmarks = 400;  ///< >= 4; shapes with fewer points take all
  SmacofOptions smacof{};
  /// An embedding folds and meets itself: whether its center is inside says nothing of the shape.
  MirrorOptions mirror{.go_on_outside = true};
  bool grow_core = true;  ///< false: as the chapter has it
  LimbOptions limbs{};
};
/// The shape in its pose-invariant form (section 6.2.3): landmarks are embedded by SMACOF, the
/// other points placed from their geodesic distances to landmarks. Same elements, other positions.
Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options);
/// Segments the pose-invariant form by mirroring; the labels hold for the shape. Beyond the
/// chapter: the core's hull grows about its middle until limbs come off, each where it joins others
/// (limbs.h).
/// @throws what SegmentByMirroring throws.
Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options);

}  // namespace rangegrasp::parts
