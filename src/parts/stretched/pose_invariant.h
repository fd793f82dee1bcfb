#pragma once

#include "parts/mirror/mirroring.h"
#include "parts/stretched/smacof.h"

namespace rangegrasp::parts {

struct PoseInvariantOptions {
  int landmarks = 400;  ///< >= 4; shapes with fewer points take all
  SmacofOptions smacof;
  MirrorOptions mirror;
  double core_growth = 1.6;  ///< >= 1; the core's hull grows up to this; 1: as the chapter has it
};
/// The shape in its pose-invariant form (section 6.2.3): landmarks are embedded by SMACOF, the
/// other points placed from their geodesic distances to landmarks. Same elements, other positions.
Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options);
/// Segments the pose-invariant form by mirroring; the labels hold for the shape. Beyond the
/// chapter: the core's hull of a mesh grows about its middle, as Katz et al. (2005) let their core
/// grow, to the size where most parts with a hundredth of the faces or more come off; the smallest
/// such.
/// @throws std::invalid_argument if core_growth is below 1, and what SegmentByMirroring throws.
Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options);

}  // namespace rangegrasp::parts
