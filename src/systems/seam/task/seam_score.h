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

/// The decision methods that are compared, listed after the single detectors.
inline constexpr auto kDecisions = base::ValuesOf<DecisionMethod>();
/// Detectors, including the fourth, and decision methods: the rows of table 3.2.
constexpr std::size_t kLocalStep = kDetectors;
constexpr std::size_t kAlone = kDetectors + 1;
constexpr std::size_t kMethods = kAlone + kDecisions.size();
std::string TitleOf(DecisionMethod decision);
std::string MethodTitle(std::size_t method);
/// The method's row in tables 3.2 and 3.3; empty if it has none.
std::string PublishedRow(std::size_t method);

/// Tolerances of tables 3.2 and 3.3.
inline constexpr std::array kTolerances_px = {3.0, 10.0, 12.0, 18.0};

/// Number of profiles, and number of positions within each tolerance.
struct Tally {
  int profiles = 0;
  std::array<int, kTolerances_px.size()> within{};

  void Count(double error_px);  ///< NaN: no position
  Tally& operator+=(const Tally& other);
};
using Tallies = std::array<Tally, kMethods>;

/// Parameters of a case. Seams of kRates have no method and no hazard.
struct SeamParams {
  int number = 0;  ///< of the seam or run, from 0
  EdgeShape shape = EdgeShape::kStep;
  std::optional<DecisionMethod> method = {};
  Hazard hazard = Hazard::kNone;
};

/// Counts of one seam. Edges outside the line are not counted.
struct SeamResult {
  SeamParams params;
  double height_m = 0.0;
  int profiles = 0;  ///< all that were scanned
  Tallies all = {};
  Tallies center = {};                  ///< label in the middle half of the line
  Tallies boundary = {};                ///< label in an outer quarter
  std::array<int, kMethods> no_edge{};  ///< profiles reported without an edge; 0 for detectors
};

/// One closed-loop run with one decision method.
struct RunResult : TrackScore {
  SeamParams params = {};      ///< as given to RunResultFrom; ScoreRun leaves it empty
  bool stopped_early = false;  ///< stopped although no hazard was in the sensor's view
  double settled_m = 0.0;      ///< along the track, after the first kSettle_m
};

/// The reading of each decision method for one profile.
using Readings = std::array<Reading, kDecisions.size()>;
/// Edge position of each method [column].
std::array<std::optional<double>, kMethods> PositionsOf(const Readings& readings);

/// Passes the profiles of a recorded seam, in order, to a tracker of each decision method.
/// @param take  receives each profile's index, its readings, and the trackers that still hold it
void ReadSeam(
    const SeamExperiment& experiment, const Calibration& calibration, const Recording& recording,
    const std::function<void(std::size_t, const Readings&, const std::vector<EdgeTracker>&)>& take);

/// Scores every method on a recorded seam; the experiment's seams are numbered from 0.
SeamResult ScoreSeam(const SeamExperiment& experiment, const Calibration& calibration,
                     const Recording& recording, int number);
/// Scores a run against the ground truth of its mats.
RunResult ScoreRun(const SeamExperiment& experiment, const TrackedRun& tracked);

// Cases, and results for the store: JSON objects with numbers that are read back unchanged.

/// "seam" and "shape", or "run", "shape", "method" and "hazard".
experiment::Params ParamsOf(const SeamParams& params);
/// @throws base::InputError if the parameters are not those of a seam.
SeamParams ParamsFrom(const experiment::Params& params);

/// Without the case's own parameters (number, shape).
std::string ToJson(const SeamResult& result);
std::string ToJson(const RunResult& result);
/// @throws base::RunError if the text is not such a result.
SeamResult SeamResultFrom(const SeamParams& params, const std::string& json);
RunResult RunResultFrom(const SeamParams& params, const std::string& json);

/// The rows of table 3.1. The sum is measured separately, from camera rows to the decided position.
inline constexpr std::array kTimedSteps = {"Profile Pre-Processing", "Model-Fitting",
                                           "Local Weighted-Voting", "Gradient-Accumulation",
                                           "Sum including edge voting"};

/// Time of each step for all profiles of a seam together [s], in the order of kTimedSteps.
std::vector<std::pair<std::string, double>> TimeSteps(const SeamExperiment& experiment,
                                                      const Calibration& calibration,
                                                      const Recording& recording);

/// Adds what ReportOf needs in addition to the records, and the hash of the sensor's file.
void AddTo(experiment::Stamp& stamp, const SeamExperiment& experiment);

/// The tables of a seam experiment next to the published ones: 3.1 to 3.3 and 3.5 for rates, errors
/// along the path for closed loops, the number of stops in time for hazards. A case that crashed or
/// timed out counts as not found, not followed or not stopped in time.
/// @throws base::InputError if a published table in the stamp is invalid.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::seam
