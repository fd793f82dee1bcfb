#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"
#include "experiment/task.h"
#include "seam/calibration.h"
#include "seam/stitching/closed_loop.h"
#include "seam/stitching/mats.h"
#include "seam/stitching/stripe_sensor.h"

/// Experiments of chapter 3: detection rates on recorded seams, and a stitching head in a closed
/// loop (docs/seam.md).
namespace rangegrasp::seam {

/// What a seam experiment measures.
enum class SeamKind {
  kRates,    ///< detection rates of every method on recorded seams (tables 3.2, 3.3, 3.5)
  kTracks,   ///< closed loop along curved seams
  kHazards,  ///< closed loop towards a mat end or an obstacle
};
constexpr std::array<std::string_view, 3> WordsOf(SeamKind) {
  return {"rates", "tracks", "hazards"};
}

/// The hazard in front of a head.
enum class Hazard { kNone, kMatEnd, kObstacle };
constexpr std::array<std::string_view, 3> WordsOf(Hazard) {
  return {"none", "mat_end", "obstacle"};
}

struct SeamExperiment {
  std::uint64_t seed = 1;
  SeamKind kind = SeamKind::kRates;
  std::filesystem::path sensor_file;
  StripeSensorOptions sensor;
  MatTexture texture;  ///< typical; each seam's mats vary around it
  std::vector<EdgeShape> shapes = {EdgeShape::kStep,   EdgeShape::kDouble,  EdgeShape::kSlant,
                                   EdgeShape::kConvex, EdgeShape::kConcave, EdgeShape::kNone};
  int seams = 60;
  std::vector<DecisionMethod> decisions = {DecisionMethod::kVoting, DecisionMethod::kWeights,
                                           DecisionMethod::kSteps};
  RecordOptions record;  ///< its speed is also the head's
  double half_circle_radius_m = 0.0;
  TrackOptions track;                                       ///< its tracker also serves kRates
  std::filesystem::path reference, improvements, runtimes;  ///< published tables; may be empty
};

/// Reads only the experiment's own keys.
void ReadKeys(base::YamlMap& map, SeamExperiment& experiment);
/// Reads these keys to the end of the file, and the sensor file that they name.
/// @throws base::InputError naming file, line and key.
SeamExperiment ReadSeamExperiment(base::YamlMap& map, const experiment::Common& common);
/// Reads a file, with the keys that every kind of experiment has.
SeamExperiment ReadSeamExperiment(const std::filesystem::path& file);

/// Seed of all random values of one seam.
std::uint64_t SeamSeed(const SeamExperiment& experiment, int number);
EdgeShape ShapeOf(const SeamExperiment& experiment, int number);
/// The mats of a seam or run, numbered from 0; they depend only on the experiment and the number.
MatOptions MatsOf(const SeamExperiment& experiment, int number);
Hazard HazardOf(const MatOptions& mats, double length_m);
TrackerOptions TrackerFor(const SeamExperiment& experiment, DecisionMethod method);

/// Scans of the calibration body, from which an experiment's calibration is computed.
std::vector<CalibrationScan> CalibrationScansOf(const SeamExperiment& experiment,
                                                const StripeSensor& sensor);
Calibration CalibrationOf(const SeamExperiment& experiment, const StripeSensor& sensor);

/// Profiles over a seam's mats with their labels.
Recording RecordSeam(const SeamExperiment& experiment, const StripeSensor& sensor, int number);

/// A closed-loop run with everything that happened on the way, and the mats it ran over.
struct TrackedRun {
  Mats mats;
  TrackResult result;
};
TrackedRun TrackRun(const SeamExperiment& experiment, const StripeSensor& sensor,
                    const Calibration& calibration, DecisionMethod method, int run);

}  // namespace rangegrasp::seam
