#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "seam/calibration.h"
#include "seam/stitching/recording.h"
#include "seam/task/seam_experiment.h"

namespace rangegrasp::seam_task {

/// The rows of table 3.1. The sum is of a profile from the camera's rows to the decided position,
/// measured by itself.
inline constexpr std::array kTimedSteps = {"Profile Pre-Processing", "Model-Fitting",
                                           "Local Weighted-Voting", "Gradient-Accumulation",
                                           "Sum including edge voting"};

/// What each step takes for all profiles of a seam together [s], in the order of kTimedSteps.
std::vector<std::pair<std::string, double>> TimeSteps(const SeamExperiment& experiment,
                                                      const seam::Calibration& calibration,
                                                      const stitching::Recording& recording);

}  // namespace rangegrasp::seam_task
