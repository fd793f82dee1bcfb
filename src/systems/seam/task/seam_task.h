#pragma once

#include <string>
#include <vector>

#include "base/draw/plot.h"
#include "experiment/task.h"
#include "seam/stitching/stripe_sensor.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {

/// Chapter 3: a case is one recorded seam (`seam-0007`; its group is the shape of its edge), or one
/// closed-loop run with one way to decide (`run-0004-voting`; its group is that way, or what the
/// head runs towards).
const experiment::TaskKind& SeamTask();

/// A line a profile: its number, from 1, and the column where its edge is; nothing without one.
std::string LabelsCsv(const Recording& recording);

/// The tracker's last profile: the heights as measured and as prepared, the three detectors' weight
/// functions and positions, and what was decided.
std::vector<draw::Panel> ProfilePanels(const EdgeTracker& tracker, const Reading& reading,
                                       const LineGeometry& line);

}  // namespace rangegrasp::seam
