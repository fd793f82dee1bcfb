#pragma once

#include <array>
#include <string_view>

#include "experiment/task.h"

namespace rangegrasp::cylinders {

/// Where the points of a cylinder come from.
enum class Source {
  kPerfect,  ///< range images without noise, as the dissertation describes its own
  kNoisy,    ///< the same with the scanner's noise
  kScanned,  ///< the simulated line scanner
};
constexpr std::array<std::string_view, 3> WordsOf(Source) {
  return {"perfect", "noisy", "scanned"};
}

enum class Method {
  kLsf,      ///< least squares, as published
  kPrinted,  ///< random circle fitting exactly as printed
  kRcf,      ///< random circle fitting with our additions
  kPcl,      ///< the Point Cloud Library's cylinder model
  kRefined,  ///< random circle fitting, refined
};
constexpr std::array<std::string_view, 5> WordsOf(Method) {
  return {"lsf", "rcf_as_printed", "rcf", "pcl", "refined"};
}

/// The table to reproduce.
enum class Shown {
  kResolution,  ///< table 4.3, figure 4.13
  kIterations,  ///< table 4.4, figures 4.14 to 4.19
};
constexpr std::array<std::string_view, 2> WordsOf(Shown) { return {"resolution", "iterations"}; }

/// `task: cylinder_fits`: comparison of fits of single cylinders (tables 4.3 and 4.4). A case is
/// one range image, which is given to all methods; the group is its source.
const experiment::TaskKind& CylindersTask();

/// Keys of Stamp::data: what is shown (a word), the rows as JSON, the noise of source noisy [mm].
inline constexpr const char* kShown = "shown";
inline constexpr const char* kRows = "rows";
inline constexpr const char* kNoise = "noise_mm";
/// Suffix after a fit's name in a result's seconds: the part of its time spent on preparation.
inline constexpr const char* kPreparation = " preparation";

/// For each source, table 4.3 or 4.4, with the published figures, and the figures (4.13, or 4.14 to
/// 4.19) as SVG. Means are over the fits that did not fail; cases without a result count as failed.
/// @throws base::InputError if the published table in the stamp is invalid.
experiment::Report ComparisonReport(const experiment::Stamp& stamp,
                                    const std::vector<experiment::Record>& records);

/// `task: cylinder_recall`: how often given cylinders are detected in clutter, by the line scanner
/// or on synthetic rays. A case is one table.
const experiment::TaskKind& RecallTask();

/// `task: cylinder_demo`: the live demo of section 4.4. A case is one run: one of several given
/// cylinders among other objects is wanted, grasped, and handed over or put down.
const experiment::TaskKind& DemoTask();

/// Table 4.1: events of each kind of problem compared with the published ones, with and without
/// influence on the run; the number of handovers; the number of pulls that were felt.
experiment::Report DemoReport(const experiment::Stamp& stamp,
                              const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
