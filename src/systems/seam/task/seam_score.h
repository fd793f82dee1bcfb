#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "base/words.h"
#include "seam/task/seam_experiment.h"

namespace rangegrasp::seam_task {

/// The ways to decide that are compared, after the detectors alone.
inline constexpr auto kDecisions = base::ValuesOf<seam::DecisionMethod>();
/// Detectors, with the fourth, and decisions: the rows of table 3.2.
constexpr std::size_t kLocalStep = seam::kDetectors;
constexpr std::size_t kAlone = seam::kDetectors + 1;
constexpr std::size_t kMethods = kAlone + kDecisions.size();
/// As table 3.2 calls them, where it knows them.
std::string TitleOf(seam::DecisionMethod decision);
std::string MethodTitle(std::size_t method);

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
  stitching::EdgeShape shape = stitching::EdgeShape::kStep;
  double height_m = 0.0;
  int profiles = 0;  ///< all that were scanned
  Tallies all;
  Tallies center;                       ///< label in the middle half of the line
  Tallies boundary;                     ///< label in an outer quarter
  std::array<int, kMethods> no_edge{};  ///< profiles told to have none; 0 of detectors
};

/// One closed-loop run with one way to decide.
struct RunResult {
  int run = 0;
  seam::DecisionMethod method = seam::DecisionMethod::kVoting;
  Hazard hazard = Hazard::kNone;
  stitching::TrackEnd end = stitching::TrackEnd::kDone;
  bool reached_hazard = false;
  bool stopped_early = false;  ///< stopped although no hazard was in the sensor's view
  double settled_m = 0.0;  ///< along the track, after the first kSettle_m: what the errors are of
  double mean_error_m = 0.0;
  double p95_error_m = 0.0;
  double max_error_m = 0.0;
  double share_within_1mm = 0.0;
  double rest_m = 0.0;  ///< where along the track the head came to rest
  /// Half circles: along the track, after the first kSettle_m, followed within 1 mm and not within
  /// kCorner_m of a corner.
  double good_beside_corners_m = 0.0;
};
/// Corners of a half circle: rounding and smoothing reach this far from them.
inline constexpr double kCorner_m = 6e-3;
/// Where along the track the seam of a half circle has its corners; none without one.
std::vector<double> CornersOf(const SeamExperiment& experiment);

/// Hands the profiles of a recorded seam to a tracker of each way to decide, in order.
/// @param told  of each profile: its position, what each way to decide (kDecisions) made of it, and
/// the trackers, which hold it until the next one
void ReadSeam(
    const SeamExperiment& experiment, const seam::Calibration& calibration,
    const stitching::Recording& recording,
    const std::function<void(std::size_t, const std::array<seam::Reading, kDecisions.size()>&,
                             const std::vector<seam::EdgeTracker>&)>& told);

/// Every method on a recorded seam, a number of the experiment from 0.
SeamResult ScoreSeam(const SeamExperiment& experiment, const seam::Calibration& calibration,
                     const stitching::Recording& recording, int number);
/// A run, against the truth that its mats know.
RunResult ScoreRun(const SeamExperiment& experiment, seam::DecisionMethod method, int run,
                   const TrackedRun& tracked);

}  // namespace rangegrasp::seam_task
