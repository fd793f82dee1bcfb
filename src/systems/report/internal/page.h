#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/record.h"
#include "experiment/store.h"
#include "experiment/task.h"

namespace rangegrasp::report {

/// Makes a folder ready for a report; removes the data of an earlier one, which may have failed.
/// @throws base::InputError if something else is in it, or the libraries that the page draws with
/// are not installed.
void PrepareFolder(const std::filesystem::path& folder);

/// Writes the page itself, and in `lib` the libraries with their licences: it needs no network.
void WritePage(const std::filesystem::path& folder);

/// A run that is reported on.
struct Run {
  std::string name;
  const experiment::TaskKind* kind = nullptr;
  experiment::Results results;
  experiment::Report tables;
};

/// Writes what the page shows of runs into a report's folder: `data.js` (tables, charts, pairs, a
/// line a case) and `records/<i>.js` (all of a case's record), which are loaded when a case is
/// looked at. Cases are numbered from 0, run after run.
/// @param views  numbers of the cases that have one
/// @param note   a sentence about which have one; may be empty
/// @throws base::InputError as the kinds' charts.
void WriteData(const std::vector<Run>& runs, const std::set<std::size_t>& views,
               const std::string& note, const std::filesystem::path& folder);

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
