#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::report {

/// Which cases of a run can be looked at.
enum class ViewChoice { kSome, kAll, kNone };
constexpr std::array<std::string_view, 3> WordsOf(ViewChoice) { return {"some", "all", "none"}; }

/// Of kSome: all that failed, and so many that did not, spread evenly over the run.
inline constexpr std::size_t kSuccessesShown = 60;

/// Positions in records, ascending.
/// @param success  the outcome that counts as one; empty: none is better than another, and so many
/// are spread over all
std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice);

}  // namespace rangegrasp::report
