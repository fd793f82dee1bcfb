#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::report {

/// Which cases of a run can be looked at.
enum class ViewChoice { kSome, kAll, kNone };
constexpr std::array<std::string_view, 3> WordsOf(ViewChoice) { return {"some", "all", "none"}; }

/// Of kSome: at most so many that failed, and so many that did not, each spread evenly over the
/// run.
inline constexpr std::size_t kFailuresShown = 100;
inline constexpr std::size_t kSuccessesShown = 60;
/// What a report of kSome may take [byte].
inline constexpr std::uintmax_t kMaxReport_bytes = 60'000'000;

/// Positions in records, ascending.
/// @param success  the outcome that counts as one; empty: none is better than another, and so many
/// are spread over all
std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice);

/// Which views may stay where all together would be too large: as many as fit, spread evenly.
/// @param sizes  of the views [byte], in their order
/// @return positions in sizes, ascending
std::vector<std::size_t> Fitting(const std::vector<std::uintmax_t>& sizes,
                                 std::uintmax_t max_bytes);

}  // namespace rangegrasp::report
