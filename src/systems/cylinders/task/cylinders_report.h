#pragma once

#include "experiment/record.h"
#include "experiment/report.h"

namespace rangegrasp::cylinders {

/// Stamp::data: the word of what is shown, the rows as JSON, the noise of source noisy [mm], the
/// published table's text.
inline constexpr const char* kShown = "shown";
inline constexpr const char* kRows = "rows";
inline constexpr const char* kNoise = "noise_mm";
inline constexpr const char* kReference = "reference";
/// Behind a fit's name among a result's seconds: what of its time is preparation.
inline constexpr const char* kPreparation = " preparation";

/// For each source table 4.3 or 4.4: a line a row and method, with the published figures; with
/// fits.csv (all means), and the figures (4.13, or 4.14 to 4.19) as CSV and SVG. Means are over the
/// fits that did not fail; next to them stands how many failed of how many, and the share of all,
/// failed ones and cases without a result too, that were good (GoodRadius, GoodAxis of the notes).
/// @throws base::InputError if the published table in the stamp is none.
experiment::Report ComparisonReport(const experiment::Stamp& stamp,
                                    const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
