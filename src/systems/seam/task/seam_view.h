#pragma once

#include "experiment/view.h"
#include "seam/task/seam_score.h"

namespace rangegrasp::seam_task {

/// A recorded seam: the true edge along it beside what each detector and each way to decide told,
/// and pages of profiles: some from its begin to its end, and those that went most wrong.
experiment::View SeamView(const SeamExperiment& experiment, const seam::Calibration& calibration,
                          const stitching::Recording& recording);

/// A closed-loop run: the true edge, the needle's path and the positions that were sent, the error
/// along the path, and what each detector told on the way.
experiment::View TrackView(const SeamExperiment& experiment, const TrackedRun& tracked);

}  // namespace rangegrasp::seam_task
