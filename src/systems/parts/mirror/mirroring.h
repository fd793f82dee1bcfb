#pragma once

#include "parts/mirror/mirror_core.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// The chapter's method (section 6.2): core, then the rest by flood filling (cloud: distance d_a,
/// eq. 6.8) or face connectivity; parts from 1 by falling size. Invariant under rotation,
/// translation and scale; no thresholds. O(n log n). d_a is the mean distance of the remaining
/// points to the last of their eight nearest: to the nearest one alone, as eq. 6.8 may be read,
/// half of all points would be farther than the mean. Points that are among each other's eight
/// nearest belong together too, since a scan is not equally dense everywhere. Pieces of no more
/// than eight points go to the nearest part. Of a noisy cloud the points of its surface are
/// segmented (PointsOfSurface): noise would count as offset in eq. 6.4, and as distance in eq. 6.8.
/// @throws base::InputError if no center inside can be found and options do not go on.
Segmentation SegmentByMirroring(const Shape& shape, const MirrorOptions& options);

}  // namespace rangegrasp::parts
