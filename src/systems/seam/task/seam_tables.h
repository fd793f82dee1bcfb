#pragma once

#include <vector>

#include "experiment/task.h"
#include "seam/task/seam_experiment.h"

namespace rangegrasp::seam {

/// Puts into the stamp what ReportOf needs besides the records: the kind, the shapes, the published
/// tables and a few lengths; and into its identity the hash of the sensor's file.
void AddTo(experiment::Stamp& stamp, const SeamExperiment& experiment);

/// The tables of a seam experiment next to the published ones: for rates 3.1 to 3.3 and 3.5, for
/// closed loops the errors along the path, for hazards how many were stopped for in time. A case
/// that crashed or timed out counts as not found, not followed or not stopped in time. With
/// rows.csv: a line a seam and method, or a run.
/// @throws base::InputError if a published table in the stamp is none.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::seam
