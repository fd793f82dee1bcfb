#pragma once

#include <string>

#include "seam/task/seam_experiment.h"

namespace rangegrasp::testing_support {

inline const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;

inline seam::SeamExperiment Shipped(const std::string& name) {
  return seam::ReadSeamExperiment(kSource / "experiments" / (name + ".yaml"));
}

/// A small version of a shipped experiment, with a seed that is used for no reported result.
inline seam::SeamExperiment Small(const std::string& name, int seams) {
  auto experiment = Shipped(name);
  experiment.seed = 4711;
  experiment.seams = seams;
  experiment.record.profiles = 40;
  return experiment;
}

}  // namespace rangegrasp::testing_support
