#pragma once

#include <vector>

#include "base/rng.h"
#include "recognition/internal/evidence.h"

namespace rangegrasp::recognition::internal {

/// A perceived object as hypotheses are made from it.
struct Segment {
  geometry::PointCloud cloud_C;  ///< with normals
  geometry::Points source_C;     ///< fewer of its points, for registration
  SampleRays rays;               ///< all about it
  SampleRays coarse;
  SampleRays fine;
  SampleRays few;                            ///< between the two
  bool colored = false;                      ///< some rays have tones, and they count
  base::Pose X_TC = base::Pose::Identity();  ///< the table: z up, origin on it
  geometry::Points eyes_C;  ///< where the views stood that saw much of it; one or more
};

/// Poses in which the object would lie on the table where the segment is: the segment's extents
/// along and across the line of sight, and those of what would be seen of the object, have one
/// middle.
std::vector<base::Pose> LyingPoses(const PreparedObject& object, const Segment& segment);

/// Poses that pairs of the segment's points vote for, most votes first.
std::vector<base::Pose> VotedPoses(const PreparedObject& object, const Segment& segment,
                                   std::size_t references, base::Rng& rng);

}  // namespace rangegrasp::recognition::internal
