#pragma once

#include <array>
#include <string_view>

#include "base/yaml_map.h"
#include "seam/decision.h"
#include "seam/detectors.h"
#include "seam/preprocess.h"
#include "seam/profile.h"
#include "seam/step_track.h"

namespace rangegrasp::seam {

/// How a profile's position is decided.
enum class DecisionMethod {
  kVoting,   ///< two of three, then a line through the last profiles (section 3.4)
  kWeights,  ///< sum of weights with historic edge positions (section 3.5)
  /// Our own: as kWeights, but the sums of earlier profiles fade out instead of being forgotten,
  /// and a candidate of local weighted-voting counts for the columns around it too.
  kAccumulated,
  kSteps,  ///< our own: the fourth detector, tracked before it is judged (seam/step_track.h)
};
constexpr std::array<std::string_view, 4> WordsOf(DecisionMethod) {
  return {"voting", "weights", "accumulated", "steps"};
}

/// Of kAccumulated.
struct AccumulationOptions {
  double memory = 0.8;          ///< in [0, 1): share of the last sum that each profile keeps
  double spread_columns = 6.0;  ///< > 0: standard deviation of a candidate's position
};

struct TrackerOptions {
  LineGeometry line;
  /// No step is measured this near to where the measured part of the profile ends: the windows of
  /// the geometric filter (+-12) and of the step height (+-10 of medians of +-6) are cut there.
  int border_columns = 20;
  PreprocessOptions preprocess;
  DetectorOptions detectors;
  DecisionMethod method = DecisionMethod::kVoting;
  double vote_tolerance_m = 1e-3;  ///< > 0
  double packet_period_s = 0.1;    ///< > 0; the robot asks for a position this often
  /// >= 0; a packet tells where, within this distance of what was decided, a step fits best to all
  /// profiles of the period, ... 0: what was decided, as published.
  double refine_m = 2e-3;
  double keep_m = 0.5e-3;  ///< ... but for what was decided this near to it, which is sharper
  /// A step counts only if another profile bears it out; false: at once, as published, and as a
  /// single profile needs it. kSteps asks a single profile for more evidence instead.
  bool confirm = true;
  LinePredictionOptions line_prediction;
  HistoryOptions history;
  StepOptions step;
  AccumulationOptions accumulation;
  StepTrackOptions step_track;
  bool positive_edge = true;  ///< false: high at small columns; profiles are mirrored
};

/// All windows above are in columns of the base sensor, 12 a mm. These cover the same lengths in
/// the line's own columns.
TrackerOptions WithWindowsOfLine(const TrackerOptions& options);

/// @throws std::invalid_argument naming the option that is out of range.
void CheckOptions(const TrackerOptions& options);

/// Reads the keys of TrackerOptions; what is absent keeps its default. Leaves Finish to the caller.
/// @throws base::InputError naming file, line and key.
void ReadTrackerOptions(base::YamlMap& map, TrackerOptions& options);

}  // namespace rangegrasp::seam
