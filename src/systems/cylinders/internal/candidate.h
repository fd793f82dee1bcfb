#pragma once

#include <optional>

#include "cylinders/detect.h"

namespace rangegrasp::cylinders::internal {

/// What all candidates are held against.
struct CandidateContext {
  const CylinderScene& scene;
  geometry::PointSpan places_C;             ///< where the sensor stood
  std::span<const std::uint32_t> place_of;  ///< one a point of scene.points_C
  const DetectOptions& options;
};

/// Where a given cylinder may be.
struct Candidate {
  Line axis_C;
  const Rim* rim = nullptr;  ///< nullptr: found by its barrel
};

/// The given cylinder at the candidate's axis, its pose fitted to what was seen (refine_pose) and
/// held against it (check_shape); nullopt if it is not there.
std::optional<FoundCylinder> Examine(const CandidateContext& context, const Candidate& candidate,
                                     const GivenCylinder& given);

/// The pose as published (algorithm 1, eq. 4.28): barrel points along the circle's axis, the line
/// through their axis points, the centre again on it. The circle's axis is the table's normal: the
/// normal of one triple's plane is several degrees off and leaves the barrel after a few
/// centimetres.
FoundCylinder PublishedPose(const CandidateContext& context, const Rim& rim,
                            const GivenCylinder& given);

}  // namespace rangegrasp::cylinders::internal
