#pragma once

#include <string>

#include "seam/tracker.h"
#include "stitching/closed_loop.h"

namespace rangegrasp::tasks::seam_task {

/// SVG of the tracker's last profile: the heights as measured and as prepared, the three detectors'
/// weight functions and positions, and what was decided.
std::string ProfileSvg(const seam::EdgeTracker& tracker, const seam::Reading& reading,
                       const seam::LineGeometry& line);

/// SVG of a closed-loop run: needle, edge and what the sensor told; below, the error along the
/// path.
std::string TrackSvg(const stitching::TrackResult& track, const stitching::Mats& mats,
                     double wanted_distance_m);

}  // namespace rangegrasp::tasks::seam_task
