#pragma once

#include <array>
#include <string_view>

#include "experiment/report.h"

namespace rangegrasp::times {

/// What is timed.
enum class Timed {
  kStages,         ///< table 5.1
  kSegmentations,  ///< figures 5.8 and 5.9
};
constexpr std::array<std::string_view, 2> WordsOf(Timed) { return {"stages", "segmentations"}; }

/// Stamp::data: the word of what is timed.
inline constexpr const char* kTimed = "timed";

/// Table 5.1 (each stage's median over the scenes and the published one), or figures 5.8 and 5.9
/// (a row for each scene), with the latter as CSV and SVG among the files.
/// @throws base::InputError if the reference in the stamp is no published table.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::times
