#pragma once

#include <vector>

#include "geometry/cloud_file.h"
#include "geometry/observation.h"
#include "sensing/scan_truth.h"

namespace rangegrasp::trial {

/// What stands beside a written cloud's points: truth ("label", "state"), and colors where the
/// sensor sees them.
std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth);

}  // namespace rangegrasp::trial
