#pragma once

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/stamp.h"

namespace rangegrasp::times {

/// Stamp::data: the text of the published table, and the word of what is timed.
inline constexpr const char* kReference = "reference";
inline constexpr const char* kTimed = "timed";

/// Table 5.1 (each stage's median over the scenes beside the published one), or figures 5.8 and 5.9
/// (a row a scene), with the latter as CSV and SVG among the files.
/// @throws base::InputError if the reference in the stamp is no published table.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::times
