#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/record.h"
#include "experiment/stamp.h"
#include "trial/trial.h"

namespace rangegrasp::report {

/// Runs a trial again and leaves what its sensor measured as `clouds/<id>.pcd` in the folder
/// (further views: `<id>_view2.pcd`), with the truth of each sample as fields "label" and "state".
/// @return the trial's result; its data is a JSON object: "clouds" (file, rows, columns, X_WV,
/// spacing_m, measured), "objects" (name, label, target, X_WO and mass before anything moved),
/// "grasps" (all candidates). Poses are 16 numbers, row by row.
/// @throws base::RunError naming a file that cannot be written.
experiment::Result ExportTrial(const trial::Cell& cell, const trial::TrialSpec& spec,
                               const std::filesystem::path& folder);

/// A data set's annotations.json, in the manner of COCO's: lists that refer to each other by "id".
/// @param exported  what ExportTrial gave; records without data are left out
std::string AnnotationsOf(const experiment::Stamp& stamp,
                          const std::vector<experiment::Record>& exported);

}  // namespace rangegrasp::report
