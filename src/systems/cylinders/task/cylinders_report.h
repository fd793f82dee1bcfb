#pragma once

#include "experiment/record.h"
#include "experiment/report.h"

namespace rangegrasp::cylinders {

/// Keys of Stamp::data: what is shown (a word), the rows as JSON, the noise of source noisy [mm].
inline constexpr const char* kShown = "shown";
inline constexpr const char* kRows = "rows";
inline constexpr const char* kNoise = "noise_mm";
/// Suffix after a fit's name in a result's seconds: the part of its time spent on preparation.
inline constexpr const char* kPreparation = " preparation";

/// For each source, table 4.3 or 4.4: one line per row and method, with the published figures; also
/// fits.csv (all means), and the figures (4.13, or 4.14 to 4.19) as SVG. Means are over the
/// fits that did not fail. The tables also give the number of failures, including cases without a
/// result, and of fits.
/// @throws base::InputError if the published table in the stamp is invalid.
experiment::Report ComparisonReport(const experiment::Stamp& stamp,
                                    const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
