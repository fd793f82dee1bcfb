#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/words.h"
#include "experiment/task.h"
#include "seam/calibration.h"
#include "seam/stitching/stripe_sensor.h"
#include "seam/task/seam_experiment.h"

namespace rangegrasp::seam {

/// The ways to decide that are compared, after the detectors alone.
inline constexpr auto kDecisions = base::ValuesOf<DecisionMethod>();
/// Detectors, with the fourth, and decisions: the rows of table 3.2.
constexpr std::size_t kLocalStep = kDetectors;
constexpr std::size_t kAlone = kDetectors + 1;
constexpr std::size_t kMethods = kAlone + kDecisions.size();
/// Titles say which rules of our own a published method is given; a method without a published
/// origin is "own".
std::string TitleOf(DecisionMethod decision);
std::string MethodTitle(std::size_t method);
/// The method's row in tables 3.2 and 3.3; empty if it has none.
std::string PublishedRow(std::size_t method);

/// Of tables 3.2 and 3.3.
inline constexpr std::array kTolerances_px = {3.0, 10.0, 12.0, 18.0};

/// How many positions of a number of profiles lay within each tolerance.
struct Tally {
  int profiles = 0;
  std::array<int, kTolerances_px.size()> within{};

  void Count(double error_px);  ///< NaN: no position
  Tally& operator+=(const Tally& other);
};
using Tallies = std::array<Tally, kMethods>;

/// Counts of one seam. Edges beyond the line are not counted.
struct SeamResult {
  int seam = 0;
  EdgeShape shape = EdgeShape::kStep;
  double height_m = 0.0;
  int profiles = 0;  ///< all that were scanned
  Tallies all = {};
  Tallies center = {};                  ///< label in the middle half of the line
  Tallies boundary = {};                ///< label in an outer quarter
  std::array<int, kMethods> no_edge{};  ///< profiles reported to have none; 0 of detectors
};

/// One closed-loop run with one way to decide.
struct RunResult : TrackErrors {
  int run = 0;
  DecisionMethod method = DecisionMethod::kVoting;
  Hazard hazard = Hazard::kNone;
  TrackEnd end = TrackEnd::kDone;
  bool reached_hazard = false;
  bool stopped_early = false;  ///< stopped although no hazard was in the sensor's view
  double settled_m = 0.0;      ///< along the track, after the first kSettle_m
  double rest_m = 0.0;         ///< where along the track the head came to rest
  /// Half circles: along the track, after the first kSettle_m, followed within 1 mm and not within
  /// kCorner_m of a corner.
  double good_beside_corners_m = 0.0;
};
/// Corners of a half circle: rounding and smoothing reach this far from them.
inline constexpr double kCorner_m = 6e-3;
/// Where along the track the seam of a half circle has its corners; none without one.
std::vector<double> CornersOf(const SeamExperiment& experiment);

/// What each way to decide made of one profile.
using Readings = std::array<Reading, kDecisions.size()>;
/// Where each method has the edge [column].
std::array<std::optional<double>, kMethods> PositionsOf(const Readings& readings);

/// Hands the profiles of a recorded seam to a tracker of each way to decide, in order.
/// @param take  of each profile: its position, what was made of it, and the trackers, which hold it
/// until the next one
void ReadSeam(
    const SeamExperiment& experiment, const Calibration& calibration, const Recording& recording,
    const std::function<void(std::size_t, const Readings&, const std::vector<EdgeTracker>&)>& take);

/// Every method on a recorded seam, a number of the experiment from 0.
SeamResult ScoreSeam(const SeamExperiment& experiment, const Calibration& calibration,
                     const Recording& recording, int number);
/// A run, against the truth that its mats know.
RunResult ScoreRun(const SeamExperiment& experiment, DecisionMethod method, int run,
                   const TrackedRun& tracked);

// Cases, and results as the store keeps them: JSON objects whose numbers are read back the same.

/// What a case is. A seam of rates has no method and no hazard.
struct SeamParams {
  int number = 0;  ///< of the seam or run, from 0
  EdgeShape shape = EdgeShape::kStep;
  std::optional<DecisionMethod> method;
  Hazard hazard = Hazard::kNone;
};

/// "seam" and "shape", or "run", "shape", "method" and "hazard".
experiment::Params ParamsOf(const SeamParams& params);
/// @throws base::InputError if they are none.
SeamParams ParamsFrom(const experiment::Params& params);

/// Without what the case itself states (number, shape).
std::string ToJson(const SeamResult& result);
std::string ToJson(const RunResult& result);
/// @throws base::RunError if the text is no such result.
SeamResult SeamResultFrom(const SeamParams& params, const std::string& json);
RunResult RunResultFrom(const SeamParams& params, const std::string& json);

/// The rows of table 3.1. The sum is of a profile from the camera's rows to the decided position,
/// measured by itself.
inline constexpr std::array kTimedSteps = {"Profile Pre-Processing", "Model-Fitting",
                                           "Local Weighted-Voting", "Gradient-Accumulation",
                                           "Sum including edge voting"};

/// What each step takes for all profiles of a seam together [s], in the order of kTimedSteps.
std::vector<std::pair<std::string, double>> TimeSteps(const SeamExperiment& experiment,
                                                      const Calibration& calibration,
                                                      const Recording& recording);

}  // namespace rangegrasp::seam
