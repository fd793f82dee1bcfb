#include "seam/task/seam_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace rangegrasp::seam_task {
namespace {

using stitching::TrackPoint;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// A label this near to the line's end has no edge to be seen: detectors leave out as many columns.
constexpr double kMargin_columns = 20.0;
// The middle half of the line is its center (section 3.5).
constexpr double kCenterHalf = 0.25;
// A head that rests this much nearer to a hazard than its sensor's line must reach has seen it:
// fray and an obstacle's border reach out by less.
constexpr double kSeen_m = 0.002;

double ErrorOf(const std::optional<double>& column, double label) {
  return column ? std::abs(*column - label) : kNone;
}

void CountPositions(const std::array<double, kMethods>& errors, double label, int columns,
                    SeamResult& result) {
  const bool center = std::abs(label - 0.5 * (columns - 1)) < kCenterHalf * columns;
  for (std::size_t m = 0; m < kMethods; ++m) {
    result.all[m].Count(errors[m]);
    (center ? result.center : result.boundary)[m].Count(errors[m]);
  }
}

// Where a hazard begins for who comes along the track.
double BeginOf(const stitching::MatOptions& mats) {
  return mats.obstacles.empty() ? mats.end_y_m : mats.obstacles[0].y_m - mats.obstacles[0].size_y_m;
}

// Of what counts as followed (section 3.7.1).
constexpr double kGood_m = 1e-3;

double GoodBeside(const std::vector<TrackPoint>& path, const std::vector<double>& corners,
                  double wanted_m) {
  double good = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const TrackPoint& p = path[i];
    if (!(std::abs(p.distance_m - wanted_m) <= kGood_m)) continue;
    const double from = std::max(path[i - 1].y_m, path.front().y_m + stitching::kSettle_m);
    double length = std::max(0.0, p.y_m - from);
    for (const double corner : corners) {
      length -=
          std::max(0.0, std::min(p.y_m, corner + kCorner_m) - std::max(from, corner - kCorner_m));
    }
    good += std::max(0.0, length);
  }
  return good;
}

}  // namespace

// The path at the wanted distance from the circle meets that from the straight edge.
std::vector<double> CornersOf(const SeamExperiment& experiment) {
  const double radius = experiment.half_circle_radius_m;
  if (radius <= 0.0) return {};
  const double wanted = experiment.track.wanted_distance_m;
  const double apart = std::sqrt((radius + wanted) * (radius + wanted) - wanted * wanted);
  const double middle = 0.5 * experiment.track.length_m;
  return {middle - apart, middle + apart};
}

std::string TitleOf(seam::DecisionMethod decision) {
  constexpr std::array<const char*, kDecisions.size()> kTitles = {
      "Combined Result", "Sum of weights + history", "Accumulated weights", "Tracked steps"};
  return kTitles[static_cast<std::size_t>(decision)];
}

std::string MethodTitle(std::size_t method) {
  if (method >= kAlone) return TitleOf(kDecisions[method - kAlone]);
  if (method == kLocalStep) return "Local step";
  return std::string(base::Word(static_cast<seam::Detector>(method)));
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

void ReadSeam(
    const SeamExperiment& experiment, const seam::Calibration& calibration,
    const stitching::Recording& recording,
    const std::function<void(std::size_t, const std::array<seam::Reading, kDecisions.size()>&,
                             const std::vector<seam::EdgeTracker>&)>& told) {
  std::vector<seam::EdgeTracker> trackers;
  for (const auto decision : kDecisions) trackers.emplace_back(TrackerFor(experiment, decision));
  for (std::size_t i = 0; i < recording.raw.size(); ++i) {
    const seam::Profile profile = seam::Calibrate(recording.raw[i], calibration);
    std::array<seam::Reading, kDecisions.size()> readings;
    for (std::size_t d = 0; d < trackers.size(); ++d) readings[d] = trackers[d].Update(profile);
    told(i, readings, trackers);
  }
}

SeamResult ScoreSeam(const SeamExperiment& experiment, const seam::Calibration& calibration,
                     const stitching::Recording& recording, int number) {
  SeamResult result;
  result.seam = number;
  result.shape = ShapeOf(experiment, number);
  result.height_m = MatsOf(experiment, number).height_m;
  const int columns = experiment.sensor.line.columns;
  ReadSeam(experiment, calibration, recording,
           [&](std::size_t i, const auto& readings, const auto&) {
             const double label = recording.label_column[i];
             std::array<double, kMethods> errors;
             errors.fill(kNone);
             ++result.profiles;
             for (std::size_t d = 0; d < readings.size(); ++d) {
               const std::size_t m = kAlone + d;
               result.no_edge[m] += readings[d].status == seam::ProfileStatus::kNoEdge ? 1 : 0;
               errors[m] = ErrorOf(readings[d].column, label);
               if (kDecisions[d] != seam::DecisionMethod::kSteps) continue;
               errors[kLocalStep] = ErrorOf(readings[d].local_step, label);
             }
             // All but the fourth decision run the same detectors.
             for (std::size_t k = 0; k < seam::kDetectors; ++k) {
               errors[k] = ErrorOf(readings.front().detected[k], label);
             }
             if (label >= kMargin_columns && label <= columns - 1 - kMargin_columns) {
               CountPositions(errors, label, columns, result);
             }
           });
  return result;
}

RunResult ScoreRun(const SeamExperiment& experiment, seam::DecisionMethod method, int run,
                   const TrackedRun& tracked) {
  const stitching::MatOptions& mats = tracked.mats.options();
  const stitching::TrackResult& track = tracked.result;
  // Where the head came to rest, and whence.
  const TrackPoint& last = track.path.back();
  RunResult result;
  result.run = run;
  result.method = method;
  result.hazard = HazardOf(mats, experiment.track.length_m);
  result.end = track.end;
  result.reached_hazard = track.reached_hazard;
  // A head that still was further from the hazard than its sensor sees stopped for nothing.
  const double sees_to_m = last.y_m + experiment.sensor.lines_ahead_m.front();
  result.stopped_early =
      track.end != stitching::TrackEnd::kDone && sees_to_m < BeginOf(mats) - kSeen_m;
  result.settled_m = std::max(0.0, last.y_m - track.path.front().y_m - stitching::kSettle_m);
  result.mean_error_m = track.mean_error_m;
  result.p95_error_m = track.p95_error_m;
  result.max_error_m = track.max_error_m;
  result.share_within_1mm = track.share_within_1mm;
  result.rest_m = last.y_m;
  const auto corners = CornersOf(experiment);
  if (!corners.empty()) {
    result.good_beside_corners_m =
        GoodBeside(track.path, corners, experiment.track.wanted_distance_m);
  }
  return result;
}

}  // namespace rangegrasp::seam_task
