#pragma once

#include <array>
#include <string_view>

#include "base/units.h"
#include "base/yaml_map.h"
#include "trial/options.h"

namespace rangegrasp::clearing {

/// When the table is scanned again (section 5.1, fig. 5.2).
enum class Rescan {
  kEach,          ///< after each grasp
  kAfterFailure,  ///< what was taken is left out of the last scan; a failed grasp needs a new one
};
constexpr std::array<std::string_view, 2> WordsOf(Rescan) { return {"each", "after_failure"}; }

/// When a failed object is tried again.
enum class Retry {
  kAtOnce,
  kAfterOthers,  ///< those with fewer failed tries first: what was in the way may be gone by then
};
constexpr std::array<std::string_view, 2> WordsOf(Retry) { return {"at_once", "after_others"}; }

/// How a program that does not know the truth goes on after a grasp.
struct ClearingOptions {
  int runs = 100;
  Rescan rescan = Rescan::kEach;
  Retry retry = Retry::kAfterOthers;
  int tries_per_object = 3;  ///< failed grasps at one object, then it is passed over
  /// Of the whole run; 0: tries_per_object for each object of the experiment.
  int max_grasps = 0;
  /// New scans in which nothing could be done, one after the other, before the program gives up:
  /// noise may have hidden a grasp.
  int idle_scans = 2;
  /// An object is the one that a grasp has failed at where the two have at least this share of
  /// their samples in common (of those that either has): the sensor does not move between scans.
  double same_object_share = 0.5;
  /// A grasp is another one than one that has failed where the hand is further away from it than
  /// this, or turned by more: half of a fingertip's width, and what the hand's own give evens out.
  double other_grasp_m = 0.010;
  double other_grasp_rad = 15.0 * base::kDeg;
};

/// A clearing experiment, as its file states it.
struct Options {
  trial::Options grasping;
  ClearingOptions clearing;

  int MaxGrasps() const;
};

/// The keys of a clearing experiment but those that it shares with grasping.
/// @throws base::InputError
void ReadClearingKeys(base::YamlMap& map, ClearingOptions& options);
/// All keys, to the end of the map. @throws base::InputError
Options ReadOptions(base::YamlMap& map);

}  // namespace rangegrasp::clearing
