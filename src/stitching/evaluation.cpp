#include "stitching/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace rangegrasp::stitching {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// The head keeps its height over the mats to within this.
constexpr double kHeightError_m = 2e-3;
// A label this near to the line's end has no edge to be seen.
constexpr double kMargin_columns = 20.0;
constexpr int kCalibrationDistances = 9;
// A hazard lies this far along the track, so that the loop has settled before.
constexpr double kHazardBegin_m = 0.15;
constexpr double kHazardEnd_m = 0.25;

std::uint64_t SeamSeed(const Evaluation& evaluation, int number) {
  return core::DeriveSeed(core::DeriveSeed(evaluation.seed, "seam"),
                          static_cast<std::uint64_t>(number));
}

EdgeShape ShapeOf(const Evaluation& evaluation, int number) {
  return evaluation.shapes[static_cast<std::size_t>(number) % evaluation.shapes.size()];
}

// The head's place over a recording's first profile: the edge starts anywhere within the share of
// the line that the evaluation asks for.
LinePose FirstPose(const Evaluation& evaluation, const Mats& mats, core::Rng& rng) {
  const double line_m = evaluation.sensor.line.columns / evaluation.sensor.line.columns_per_m;
  const double across = rng.Uniform(-0.5, 0.5);
  LinePose pose;
  pose.height_m = rng.Uniform(-kHeightError_m, kHeightError_m);
  const double edge = mats.EdgeX(0.0);
  pose.x_m = (std::isfinite(edge) ? edge : 0.0) - across * evaluation.edge_within * line_m;
  return pose;
}

double LabelColumn(const Mats& mats, const StripeSensor& sensor, const LinePose& pose) {
  const double edge = mats.EdgeX(pose.y_m);
  if (!std::isfinite(edge)) return kNone;
  const double height = mats.At(edge, pose.y_m).height_m - pose.height_m;
  return sensor.ColumnOf(edge - pose.x_m, height);
}

seam::TrackerOptions TrackerFor(const Evaluation& evaluation, seam::DecisionMethod method) {
  seam::TrackerOptions options = evaluation.track.tracker;
  options.line = evaluation.sensor.line;
  options.method = method;
  return options;
}

double ErrorOf(const std::optional<double>& column, double label) {
  return column ? std::abs(*column - label) : kNone;
}

void CountPositions(const std::array<double, kMethods>& errors, double label, int columns,
                    SeamResult& result) {
  const bool centre = std::abs(label - 0.5 * (columns - 1)) < 0.25 * columns;
  for (int method = 0; method < kMethods; ++method) {
    const auto m = static_cast<std::size_t>(method);
    result.all[m].Count(errors[m]);
    (centre ? result.centre : result.boundary)[m].Count(errors[m]);
  }
}

}  // namespace

const char* DecisionName(seam::DecisionMethod decision) {
  switch (decision) {
    case seam::DecisionMethod::kVoting:
      return "Combined Result";
    case seam::DecisionMethod::kWeights:
      return "Sum of weights + history";
    case seam::DecisionMethod::kAccumulated:
      return "Accumulated weights";
  }
  return "?";
}

const char* MethodName(int method) {
  if (method < seam::kDetectors) return seam::Name(static_cast<seam::Detector>(method));
  return DecisionName(kDecisions[static_cast<std::size_t>(method - seam::kDetectors)]);
}

void Tally::Count(double error_px) {
  ++profiles;
  for (std::size_t i = 0; i < within.size(); ++i)
    within[i] += error_px <= kTolerances_px[i] ? 1 : 0;
}

Tally& Tally::operator+=(const Tally& other) {
  profiles += other.profiles;
  for (std::size_t i = 0; i < within.size(); ++i) within[i] += other.within[i];
  return *this;
}

MatOptions MatsOf(const Evaluation& evaluation, int number) {
  const std::uint64_t seed = SeamSeed(evaluation, number);
  const bool curved = evaluation.kind != EvaluationKind::kRates;
  MatOptions options = RandomMats(ShapeOf(evaluation, number), evaluation.texture, curved, seed);
  if (evaluation.half_circle_radius_m > 0.0) {
    options.course = {};
    options.course.half_circle_radius_m = evaluation.half_circle_radius_m;
    options.course.half_circle_y_m = 0.5 * evaluation.track.length_m;
  }
  if (evaluation.kind != EvaluationKind::kHazards) return options;
  core::Rng rng(core::DeriveSeed(seed, "hazard"));
  const double y = rng.Uniform(kHazardBegin_m, kHazardEnd_m);
  if (rng.Uniform() < 0.5) {
    options.end_y_m = y;
    return options;
  }
  MatOptions::Obstacle obstacle;
  obstacle.y_m = y;
  obstacle.x_m =
      options.course.XAt(y) - evaluation.track.wanted_distance_m + rng.Uniform(-0.01, 0.01);
  obstacle.size_x_m = rng.Uniform(0.003, 0.02);
  obstacle.size_y_m = rng.Uniform(0.003, 0.02);
  obstacle.height_m = rng.Uniform(0.0033, 0.02);
  options.obstacles.push_back(obstacle);
  return options;
}

std::vector<seam::CalibrationScan> CalibrationScansOf(const Evaluation& evaluation,
                                                      const StripeSensor& sensor) {
  core::Rng rng(core::DeriveSeed(evaluation.seed, "calibration"));
  return sensor.ScanBody({}, kCalibrationDistances, rng);
}

seam::Calibration CalibrationOf(const Evaluation& evaluation, const StripeSensor& sensor) {
  return seam::CalibrateFromBody({}, CalibrationScansOf(evaluation, sensor));
}

Recording Record(const Evaluation& evaluation, const StripeSensor& sensor, int number) {
  const std::uint64_t seed = SeamSeed(evaluation, number);
  const Mats mats(MatsOf(evaluation, number), core::DeriveSeed(seed, "mats"));
  core::Rng rng(core::DeriveSeed(seed, "scan"));
  LinePose pose = FirstPose(evaluation, mats, rng);
  const double period_s = 1.0 / sensor.Rate(mats.options().texture);
  Recording recording;
  for (int i = 0; i < evaluation.profiles_per_seam; ++i) {
    pose.y_m = i * period_s * evaluation.speed_m_s;
    const seam::RawProfile* previous = recording.raw.empty() ? nullptr : &recording.raw.back();
    recording.raw.push_back(sensor.Scan(mats, pose, i * period_s, previous, rng));
    recording.label_column.push_back(LabelColumn(mats, sensor, pose));
  }
  return recording;
}

SeamResult EvaluateSeam(const Evaluation& evaluation, const StripeSensor& sensor,
                        const seam::Calibration& calibration, int number) {
  const Recording recording = Record(evaluation, sensor, number);
  std::vector<seam::EdgeTracker> trackers;
  for (const auto decision : kDecisions) trackers.emplace_back(TrackerFor(evaluation, decision));
  SeamResult result;
  result.seam = number;
  result.shape = ShapeOf(evaluation, number);
  result.height_m = MatsOf(evaluation, number).height_m;
  const int columns = evaluation.sensor.line.columns;
  for (std::size_t i = 0; i < recording.raw.size(); ++i) {
    const seam::Profile profile = seam::Calibrate(recording.raw[i], calibration);
    const double label = recording.label_column[i];
    std::array<double, kMethods> errors{};
    ++result.profiles;
    for (std::size_t d = 0; d < trackers.size(); ++d) {
      const seam::Reading reading = trackers[d].Update(profile);
      result.no_edge[d] += reading.status == seam::ProfileStatus::kNoEdge ? 1 : 0;
      errors[seam::kDetectors + d] = ErrorOf(reading.column, label);
      for (std::size_t k = 0; d == 0 && k < seam::kDetectors; ++k) {
        errors[k] = reading.detected[k] ? std::abs(*reading.detected[k] - label) : kNone;
      }
    }
    if (label >= kMargin_columns && label <= columns - 1 - kMargin_columns) {
      CountPositions(errors, label, columns, result);
    }
  }
  return result;
}

TrackedRun TrackRun(const Evaluation& evaluation, const StripeSensor& sensor,
                    const seam::Calibration& calibration, seam::DecisionMethod method, int run) {
  const std::uint64_t seed = SeamSeed(evaluation, run);
  const Mats mats(MatsOf(evaluation, run), core::DeriveSeed(seed, "mats"));
  TrackOptions options = evaluation.track;
  options.tracker = TrackerFor(evaluation, method);
  options.head.speed_m_s = evaluation.speed_m_s;
  return {mats, Track(mats, sensor, calibration, options, core::DeriveSeed(seed, "track"))};
}

TrackedRun TrackRun(const Evaluation& evaluation, seam::DecisionMethod method, int run) {
  const StripeSensor sensor(evaluation.sensor);
  return TrackRun(evaluation, sensor, CalibrationOf(evaluation, sensor), method, run);
}

RunResult EvaluateRun(const Evaluation& evaluation, const StripeSensor& sensor,
                      const seam::Calibration& calibration, seam::DecisionMethod method, int run) {
  const auto [mats, track] = TrackRun(evaluation, sensor, calibration, method, run);
  const MatOptions& mat_options = mats.options();
  RunResult result;
  result.run = run;
  result.method = method;
  if (!mat_options.obstacles.empty()) {
    result.hazard = "obstacle";
  } else if (mat_options.end_y_m < evaluation.track.length_m) {
    result.hazard = "mat_end";
  }
  result.end = track.end;
  result.reached_hazard = track.reached_hazard;
  // A head that still was further from the hazard than its sensor sees stopped for nothing.
  const double hazard_y = mat_options.obstacles.empty()
                              ? mat_options.end_y_m
                              : mat_options.obstacles[0].y_m - mat_options.obstacles[0].size_y_m;
  const double sees_to =
      track.path.empty() ? 0.0 : track.path.back().y_m + evaluation.sensor.lines_ahead_m.front();
  result.stopped_early = track.end != TrackEnd::kDone && sees_to < hazard_y - 0.002;
  if (!track.path.empty()) {
    result.settled_m = std::max(0.0, track.path.back().y_m - track.path.front().y_m - kSettle_m);
  }
  result.mean_error_m = track.mean_error_m;
  result.p95_error_m = track.p95_error_m;
  result.max_error_m = track.max_error_m;
  result.share_within_1mm = track.share_within_1mm;
  return result;
}

EvaluationResult Evaluate(const Evaluation& evaluation, int jobs,
                          const EvaluationProgress& progress) {
  const StripeSensor sensor(evaluation.sensor);
  const seam::Calibration calibration = CalibrationOf(evaluation, sensor);
  EvaluationResult result;
  if (evaluation.kind == EvaluationKind::kRates) {
    result.seams.resize(static_cast<std::size_t>(evaluation.seams));
    core::ForEach(evaluation.seams, jobs, progress, [&](int i) {
      result.seams[static_cast<std::size_t>(i)] = EvaluateSeam(evaluation, sensor, calibration, i);
    });
    return result;
  }
  // Accumulated weights presume that the edge stays where it is on the line; before a head that
  // turns it does not.
  constexpr int decisions = kLoopDecisions;
  const int runs = decisions * evaluation.seams;
  result.runs.resize(static_cast<std::size_t>(runs));
  core::ForEach(runs, jobs, progress, [&](int i) {
    const auto decision = kDecisions[static_cast<std::size_t>(i % decisions)];
    result.runs[static_cast<std::size_t>(i)] =
        EvaluateRun(evaluation, sensor, calibration, decision, i / decisions);
  });
  return result;
}

}  // namespace rangegrasp::stitching
