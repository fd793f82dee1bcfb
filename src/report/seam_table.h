#pragma once

#include <map>
#include <string>

#include "report/table.h"
#include "stitching/evaluation.h"

namespace rangegrasp::report {

/// The tables of a seam evaluation beside the published ones: for rates 3.2 or 3.3 (every method at
/// four tolerances), the improvements of table 3.5, every edge shape, and how many profiles without
/// an edge were told as such; for closed loops the errors along the path, stops and hazards.
/// @throws core::InputError if a published table cannot be read.
std::string FormatSeam(const stitching::Evaluation& evaluation,
                       const stitching::EvaluationResult& result, TableFormat format);

/// One line a seam or run, as CSV: what the tables are made of.
std::string SeamRowsCsv(const stitching::EvaluationResult& result);

}  // namespace rangegrasp::report
