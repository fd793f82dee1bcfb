#pragma once

#include <vector>

#include "experiment/task.h"
#include "seam/task/seam_experiment.h"

namespace rangegrasp::seam {

/// Adds to the stamp what ReportOf needs in addition to the records: the kind, the published
/// tables and a few lengths; adds the hash of the sensor's file to its identity.
void AddTo(experiment::Stamp& stamp, const SeamExperiment& experiment);

/// The tables of a seam experiment next to the published ones: 3.1 to 3.3 and 3.5 for rates, errors
/// along the path for closed loops, the number of stops in time for hazards. A case that crashed or
/// timed out counts as not found, not followed or not stopped in time. rows.csv has one line per
/// seam and method, or per run.
/// @throws base::InputError if a published table in the stamp is invalid.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::seam
