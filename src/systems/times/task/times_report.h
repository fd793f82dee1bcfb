#pragma once

#include <array>
#include <string_view>

#include "experiment/report.h"

namespace rangegrasp::times {

/// The timed quantity.
enum class Timed {
  kStages,         ///< table 5.1
  kSegmentations,  ///< figures 5.8 and 5.9
};
constexpr std::array<std::string_view, 2> WordsOf(Timed) { return {"stages", "segmentations"}; }

/// Key of Stamp::data: the word of the timed quantity.
inline constexpr const char* kTimed = "timed";

/// Table 5.1 (each stage's median over the scenes, and the published time), or figures 5.8 and 5.9
/// (a row per scene).
/// @throws base::InputError if the reference in the stamp is not a published table.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::times
