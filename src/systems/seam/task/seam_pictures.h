#pragma once

#include <array>
#include <vector>

#include "base/draw/plot.h"
#include "seam/stitching/closed_loop.h"
#include "seam/tracker.h"

namespace rangegrasp::seam_task {

/// The dissertation's colors of the three detectors (fig. 3.17): green, blue, red.
inline constexpr std::array kDetectorColors = {"#2ca02c", "#1f77b4", "#d62728"};

/// The tracker's last profile: the heights as measured and as prepared, the three detectors' weight
/// functions and positions, and what was decided.
std::vector<draw::Panel> ProfilePanels(const seam::EdgeTracker& tracker,
                                       const seam::Reading& reading,
                                       const seam::LineGeometry& line);

/// A closed-loop run: needle, edge and what the sensor told; below, the error along the path.
std::vector<draw::Panel> TrackPanels(const stitching::TrackResult& track,
                                     const stitching::Mats& mats, double wanted_distance_m);

}  // namespace rangegrasp::seam_task
