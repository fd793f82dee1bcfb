#pragma once

#include <string>
#include <vector>

#include "base/draw/plot.h"
#include "experiment/task.h"
#include "seam/stitching/stripe_sensor.h"
#include "seam/tracker.h"

namespace rangegrasp::seam {

/// Chapter 3: a case is one recorded seam (`seam-0007`; its group is the shape of its edge), or one
/// closed-loop run with one decision method (`run-0004-voting`; its group is the method or the
/// hazard).
const experiment::TaskKind& SeamTask();

/// CSV with one line per profile: its number, from 1, and the column of its edge, if any.
std::string LabelsCsv(const Recording& recording);

/// Plots of the tracker's last profile: the heights as measured and as prepared, the three
/// detectors' weight functions and positions, and the decision.
std::vector<draw::Panel> ProfilePanels(const EdgeTracker& tracker, const Reading& reading,
                                       const LineGeometry& line);

}  // namespace rangegrasp::seam
