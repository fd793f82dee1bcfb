#include "seam/task/seam_experiment.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"
#include "experiment/experiment.h"

namespace rangegrasp::seam {
namespace {

using base::kMm;
using base::YamlMap;

// Limit of counts: it rejects mistakes, not large experiments.
constexpr int kMaxCount = 1'000'000;
// Number of distances at which the calibration body is scanned: nearly twice the five terms of the
// fitted 4th-order polynomial.
constexpr int kCalibrationDistances = 9;

// At the start of a closed loop the sensor must see the edge: within this share of half its line.
constexpr double kSeenAtStart = 0.7;

// Scales down a course that starts outside the sensor's line until it is on the line.
void BeginOnLine(const SeamExperiment& experiment, EdgeCourse& course) {
  const LineGeometry& line = experiment.sensor.line;
  const double seen_m = kSeenAtStart * line.ToMeters(line.columns - 1);
  const double start_m = course.XAt(experiment.sensor.lines_ahead_m.front());
  // The needle starts at the wanted distance from x = 0, with the line's middle ahead of it.
  const double middle_m = -experiment.track.wanted_distance_m;
  if (std::abs(start_m - middle_m) <= seen_m) return;
  course.Scale((middle_m + std::copysign(seen_m, start_m - middle_m)) / start_m);
}

void ReadTexture(YamlMap map, MatTexture& texture) {
  map.ReadScaled("weave_relief_mm", texture.weave_relief_m, kMm, 0.0, 2.0,
                 "height of the woven relief");
  map.ReadScaled("fuzz_mm", texture.fuzz_m, kMm, 0.0, 1.0,
                 "fine roughness of the fibres, standard deviation");
  map.ReadScaled("waviness_mm", texture.waviness_m, kMm, 0.0, 10.0,
                 "height of the waves of the mats, standard deviation");
  map.ReadScaled("waviness_length_mm", texture.waviness_length_m, kMm, 0.2, 1000.0,
                 "mean half wavelength of these waves");
  map.ReadScaled("fray_mm", texture.fray_m, kMm, 0.0, 5.0,
                 "deviation of the edge from its course, standard deviation");
  map.ReadScaled("filaments_per_mm", texture.filaments_per_m, 1.0 / kMm, 0.0, 10.0,
                 "number of filaments that stick out of the edge");
  map.ReadScaled("loose_filaments_per_mm2", texture.loose_filaments_per_m2, 1e6, 0.0, 1.0,
                 "number of filaments that stick out of the mats elsewhere");
  map.ReadScaled("filament_height_mm", texture.filament_height_m, kMm, 0.0, 10.0,
                 "height of the highest filament");
  map.Read("detached_share", texture.detached_share, 0.0, 1.0,
           "share of the edge with a detached bundle of fibres next to it");
  map.Read("gloss", texture.gloss, 0.0, 1.0,
           "how often a tow reflects the light away from the camera: 0 dull, 1 like a mirror");
  map.Read("darkness", texture.darkness, 0.0, 1.0, "darkness of the mats: 0 bright, 1 black");
  map.Finish();
}

void ReadTrack(YamlMap map, TrackOptions& options) {
  HeadOptions& head = options.head;
  map.ReadScaled("wanted_distance_mm", options.wanted_distance_m, kMm, 0.0, 50.0,
                 "distance of the seam from the edge, on the low side");
  map.ReadScaled("length_mm", options.length_m, kMm, 50.0, 100'000.0,
                 "length of the planned track");
  map.Read("rotate", head.rotate,
           "whether the head also rotates along the seam; false: it only moves sideways");
  map.ReadScaled("max_lateral_speed_mm_s", head.max_lateral_speed_m_s, kMm, 1.0, 2000.0,
                 "maximum lateral speed of the head's corrections");
  map.ReadScaled("max_acceleration_mm_s2", head.max_acceleration_m_s2, kMm, 1.0, 20'000.0,
                 "maximum acceleration of the head");
  map.Read("max_rotation_rad_s", head.max_rotation_rad_s, 0.01, 20.0,
           "maximum rotation speed of the head");
  map.Read("max_rotation_acceleration_rad_s2", head.max_rotation_acceleration_rad_s2, 0.01, 200.0,
           "maximum rotation acceleration of the head");
  map.Finish();
}

void ReadSeams(YamlMap& map, SeamExperiment& experiment) {
  map.Read("shapes", experiment.shapes, "shapes of the edges, used in turn");
  map.Read(
      "seams", experiment.seams, 1, kMaxCount,
      "number of recorded seams; tracks and hazards: number of runs with each decision method");
  map.Read("decisions", experiment.decisions,
           "tracks and hazards: decision methods that control the head, each in separate runs");
  // A method listed twice would give two cases with the same name.
  auto sorted = experiment.decisions;
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end()) {
    map.Fail("decisions", fmt::format("has '{}' twice", base::Word(*twice)));
  }
  map.Read("profiles_per_seam", experiment.record.profiles, 1, kMaxCount,
           "number of profiles of a recorded seam");
  map.Read("edge_within", experiment.record.edge_within, 0.0, 1.0,
           "share of the line, around its middle, in which the edge of a recorded seam starts");
  map.ReadScaled(
      "half_circle_radius_mm", experiment.half_circle_radius_m, kMm, 0.0, 1000.0,
      "tracks: radius of a half circle in the middle of a straight seam; 0: curved seams");
  map.ReadScaled("speed_mm_s", experiment.record.speed_m_s, kMm, 1.0, 500.0,
                 "speed of the sensor along the seam");
}

std::uint64_t SeedOf(const SeamExperiment& experiment, int number, std::string_view stage) {
  return base::DeriveSeed(SeamSeed(experiment, number), stage);
}

Mats MatsAt(const SeamExperiment& experiment, int number) {
  return {MatsOf(experiment, number), SeedOf(experiment, number, "mats")};
}

}  // namespace

void ReadKeys(YamlMap& map, SeamExperiment& experiment) {
  map.Read("kind", experiment.kind,
           "what to measure: detection rates on recorded seams, closed loops along seams, or "
           "hazards at which a closed loop must stop");
  map.Require("sensor");
  map.ReadPath("sensor", experiment.sensor_file, "file of a stripe sensor");
  ReadSeams(map, experiment);
  map.ReadPath("reference", experiment.reference,
               "published rates, printed next to the measured ones; CSV");
  map.ReadPath("improvements", experiment.improvements, "published single figures, CSV");
  map.ReadPath("runtimes", experiment.runtimes, "published table 3.1 as CSV");
  ReadTexture(
      map.Child("texture", "texture of the mats; it varies around these values from seam to seam"),
      experiment.texture);
  ReadTrack(map.Child("track", "track and head of the closed loop"), experiment.track);
  ReadMonitorOptions(
      map.Child("monitor", "hazards that stop the head; also in seam detect --options"),
      experiment.track.monitor);
  auto tracker = map.Child("tracker", "edge detection; also in seam detect --options");
  ReadTrackerOptions(tracker, experiment.track.tracker);
  tracker.Finish();
}

SeamExperiment ReadSeamExperiment(YamlMap& map, const experiment::Common& common) {
  SeamExperiment experiment;
  experiment.seed = common.seed;
  ReadKeys(map, experiment);
  map.Finish();
  experiment.sensor = ReadStripeSensor(experiment.sensor_file);
  experiment.track.tracker.line = experiment.sensor.line;
  experiment.track.head.speed_m_s = experiment.record.speed_m_s;
  return experiment;
}

SeamExperiment ReadSeamExperiment(const std::filesystem::path& file) {
  auto map = YamlMap::FromFile(file);
  experiment::Common common;
  common.file = file;
  common.name = file.stem().string();
  std::string task = "grasping";  // as in all experiments
  map.Read("task", task, "kind of experiment");
  if (task != "seam") {
    throw base::InputError(file.string() + ": is an experiment of task '" + task +
                           "'; give one of task 'seam', e.g. seam_base");
  }
  experiment::ReadCommon(map, common);
  return ReadSeamExperiment(map, common);
}

std::uint64_t SeamSeed(const SeamExperiment& experiment, int number) {
  return base::DeriveSeed(base::DeriveSeed(experiment.seed, "seam"),
                          static_cast<std::uint64_t>(number));
}

EdgeShape ShapeOf(const SeamExperiment& experiment, int number) {
  return experiment.shapes[static_cast<std::size_t>(number) % experiment.shapes.size()];
}

MatOptions MatsOf(const SeamExperiment& experiment, int number) {
  const bool curved = experiment.kind != SeamKind::kRates;
  MatOptions options = RandomMats(ShapeOf(experiment, number), experiment.texture, curved,
                                  SeamSeed(experiment, number));
  if (experiment.half_circle_radius_m > 0.0) {
    options.course = {};
    options.course.half_circle_radius_m = experiment.half_circle_radius_m;
    options.course.half_circle_y_m = 0.5 * experiment.track.length_m;
  }
  if (curved) BeginOnLine(experiment, options.course);
  if (experiment.kind == SeamKind::kHazards) {
    AddRandomHazard(options, experiment.track.wanted_distance_m,
                    SeedOf(experiment, number, "hazard"));
  }
  return options;
}

Hazard HazardOf(const MatOptions& mats, double length_m) {
  if (!mats.obstacles.empty()) return Hazard::kObstacle;
  return mats.end_y_m < length_m ? Hazard::kMatEnd : Hazard::kNone;
}

TrackerOptions TrackerFor(const SeamExperiment& experiment, DecisionMethod method) {
  TrackerOptions options = experiment.track.tracker;
  options.method = method;
  return options;
}

std::vector<CalibrationScan> CalibrationScansOf(const SeamExperiment& experiment,
                                                const StripeSensor& sensor) {
  base::Rng rng(base::DeriveSeed(experiment.seed, "calibration"));
  return sensor.ScanBody({}, kCalibrationDistances, rng);
}

Calibration CalibrationOf(const SeamExperiment& experiment, const StripeSensor& sensor) {
  return CalibrateFromBody({}, CalibrationScansOf(experiment, sensor));
}

Recording RecordSeam(const SeamExperiment& experiment, const StripeSensor& sensor, int number) {
  return RecordProfiles(MatsAt(experiment, number), sensor, experiment.record,
                        SeedOf(experiment, number, "scan"));
}

TrackedRun TrackRun(const SeamExperiment& experiment, const StripeSensor& sensor,
                    const Calibration& calibration, DecisionMethod method, int run) {
  const Mats mats = MatsAt(experiment, run);
  TrackOptions options = experiment.track;
  options.tracker = TrackerFor(experiment, method);
  return {mats, Track(mats, sensor, calibration, options, SeedOf(experiment, run, "track"))};
}

}  // namespace rangegrasp::seam
