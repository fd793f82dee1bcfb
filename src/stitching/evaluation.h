#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "stitching/closed_loop.h"
#include "stitching/mats.h"
#include "stitching/stripe_sensor.h"

namespace rangegrasp::stitching {

/// What an experiment file asks for.
enum class EvaluationKind {
  kRates,    ///< detection rates of every method on recorded seams (tables 3.2, 3.3, 3.5)
  kTracks,   ///< closed loop along curved seams
  kHazards,  ///< closed loop towards a mat end or an obstacle
};

/// A seam experiment (docs/seam.md lists the keys).
struct Evaluation {
  std::string name;
  std::filesystem::path file;
  EvaluationKind kind = EvaluationKind::kRates;
  std::filesystem::path sensor_file;
  StripeSensorOptions sensor;
  MatTexture texture;  ///< typical; each seam's mats vary round it
  std::vector<EdgeShape> shapes = {EdgeShape::kStep,   EdgeShape::kDouble,  EdgeShape::kSlant,
                                   EdgeShape::kConvex, EdgeShape::kConcave, EdgeShape::kNone};
  int seams = 60;               ///< in turn of each shape; kTracks, kHazards: runs
  int profiles_per_seam = 520;  ///< kRates
  double edge_within = 0.6;  ///< kRates: share of the line, about its middle, that edges start in
  /// kTracks: > 0 makes every seam straight but for a half circle in its middle (fig. 3.25).
  double half_circle_radius_m = 0.0;
  double speed_m_s = 0.03;
  std::uint64_t seed = 1;
  TrackOptions track;                  ///< its tracker also serves kRates
  std::filesystem::path reference;     ///< published rates, or empty
  std::filesystem::path improvements;  ///< published figures of table 3.5, or empty
};

/// @throws core::InputError naming file, line and key.
Evaluation ReadEvaluation(const std::filesystem::path& file);

/// Positions that are compared: the detectors alone, then both ways to decide.
constexpr std::array kDecisions = {seam::DecisionMethod::kVoting, seam::DecisionMethod::kWeights,
                                   seam::DecisionMethod::kAccumulated};
constexpr int kMethods = seam::kDetectors + static_cast<int>(kDecisions.size());
constexpr int kLoopDecisions = 2;  ///< the first of them run closed loops
const char* DecisionName(seam::DecisionMethod decision);
constexpr std::array kTolerances_px = {3.0, 10.0, 12.0, 18.0};
const char* MethodName(int method);

/// How many positions of a number of profiles lay within each tolerance.
struct Tally {
  int profiles = 0;
  std::array<int, kTolerances_px.size()> within{};

  void Count(double error_px);  ///< NaN: no position
  Tally& operator+=(const Tally& other);
};

/// Counts of one seam. Edges beyond the line are not counted.
struct SeamResult {
  int seam = 0;
  EdgeShape shape = EdgeShape::kStep;
  double height_m = 0.0;
  int profiles = 0;  ///< all that were scanned
  std::array<Tally, kMethods> all;
  std::array<Tally, kMethods> centre;    ///< label in the middle half of the line
  std::array<Tally, kMethods> boundary;  ///< label in an outer quarter
  std::array<int, kMethods> no_edge{};   ///< profiles told to have none (decisions only)
};

/// Counts of one closed-loop run with one way to decide.
struct RunResult {
  int run = 0;
  seam::DecisionMethod method = seam::DecisionMethod::kVoting;
  std::string hazard = "none";  ///< "none", "mat_end", "obstacle"
  TrackEnd end = TrackEnd::kDone;
  bool reached_hazard = false;
  bool stopped_early = false;  ///< stopped although no hazard was in the sensor's view
  double settled_m = 0.0;  ///< along the track, after the first kSettle_m: what the errors are of
  double mean_error_m = 0.0, p95_error_m = 0.0, max_error_m = 0.0, share_within_1mm = 0.0;
};

/// One seam of a kRates evaluation, number 0 .. seams-1. Depends on the evaluation and the number
/// alone.
SeamResult EvaluateSeam(const Evaluation& evaluation, const StripeSensor& sensor,
                        const seam::Calibration& calibration, int number);
/// One run of a kTracks or kHazards evaluation.
RunResult EvaluateRun(const Evaluation& evaluation, const StripeSensor& sensor,
                      const seam::Calibration& calibration, seam::DecisionMethod method, int run);
/// The same with everything that happened on the way, and the mats it ran over.
struct TrackedRun {
  Mats mats;
  TrackResult result;
};
TrackedRun TrackRun(const Evaluation& evaluation, const StripeSensor& sensor,
                    const seam::Calibration& calibration, seam::DecisionMethod method, int run);
/// With a sensor and a calibration made for it.
TrackedRun TrackRun(const Evaluation& evaluation, seam::DecisionMethod method, int run);
/// The mats of a number, and for kRates the pose of the line at its first profile.
MatOptions MatsOf(const Evaluation& evaluation, int number);

/// Scans of the calibration body, as every evaluation's calibration is made of.
std::vector<seam::CalibrationScan> CalibrationScansOf(const Evaluation& evaluation,
                                                      const StripeSensor& sensor);
/// The sensor's calibration from them.
seam::Calibration CalibrationOf(const Evaluation& evaluation, const StripeSensor& sensor);

/// A sequence of profiles over a seam's mats, with the labelled column of each (NaN without an
/// edge).
struct Recording {
  std::vector<seam::RawProfile> raw;
  std::vector<double> label_column;
};
Recording Record(const Evaluation& evaluation, const StripeSensor& sensor, int number);

using EvaluationProgress = std::function<void(int done, int total)>;
struct EvaluationResult {
  std::vector<SeamResult> seams;  ///< kRates, in order
  std::vector<RunResult> runs;    ///< kTracks, kHazards: run after run, each with every decision
};
/// All seams or runs on `jobs` threads; the result depends on the evaluation alone.
EvaluationResult Evaluate(const Evaluation& evaluation, int jobs,
                          const EvaluationProgress& progress);

}  // namespace rangegrasp::stitching
