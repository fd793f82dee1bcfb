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

/// `task: cylinder_recall`: how often given cylinders are detected in clutter, by the line scanner
/// or on synthetic rays. A case is one table.
const experiment::TaskKind& RecallTask();

}  // namespace rangegrasp::cylinders
