#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiment/experiment.h"

namespace rangegrasp::report {

/// Prepares a folder for a report; removes the data of an earlier one, which may have failed. The
/// caller may hold its lock.
/// @throws base::InputError if the folder contains anything else, or the libraries that the page
/// draws with are not installed.
void PrepareFolder(const std::filesystem::path& folder);

/// Writes the page itself and, in `lib`, the libraries with their licences: it needs no network.
void WritePage(const std::filesystem::path& folder);

struct Run {
  std::string name;
  /// Folders of the seeds, as given, with the number of cases of each; in the records' order.
  std::vector<std::pair<std::filesystem::path, std::size_t>> stores = {};
  const experiment::TaskKind* kind = nullptr;
  experiment::Results results;
  experiment::Report tables;

  std::string Success() const { return SuccessOf(*kind, results.stamp); }
};

/// Writes the page's data about runs into a report's folder: `data.js` (tables, charts, pairs, one
/// line per case) and `records/<i>.js` (the complete records, loaded when a case is viewed). Cases
/// are numbered from 0, run after run.
/// @param views  numbers of the cases that have a view
/// @param note   a sentence about which cases have a view; may be empty
/// @throws base::InputError as thrown by the kinds' charts.
void WriteData(const std::vector<Run>& runs, const std::set<std::size_t>& views,
               const std::string& note, const std::filesystem::path& folder);

enum class ViewChoice { kSome, kAll, kNone };
constexpr std::array<std::string_view, 3> WordsOf(ViewChoice) { return {"some", "all", "none"}; }

/// For kSome: maximum numbers of failed and of other cases, each spread evenly over the run.
inline constexpr std::size_t kFailuresShown = 100;
inline constexpr std::size_t kSuccessesShown = 60;
/// Maximum size of a report with kSome [byte].
inline constexpr std::uintmax_t kMaxReport_bytes = 60'000'000;

/// Chooses the cases that get a view: positions in records, ascending.
/// @param success  the outcome that counts as success; empty: no outcome is better than another,
///                 and the views are spread over all cases
std::vector<std::size_t> ChooseViews(const std::vector<experiment::Record>& records,
                                     const std::string& success, ViewChoice choice);

/// Chooses views to keep if all together would be too large: as many as fit, spread evenly.
/// @param sizes  of the views [byte], in their order
/// @return positions in sizes, ascending
std::vector<std::size_t> Fitting(const std::vector<std::uintmax_t>& sizes,
                                 std::uintmax_t max_bytes);

}  // namespace rangegrasp::report
