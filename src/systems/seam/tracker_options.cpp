#include "seam/tracker_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/units.h"

namespace rangegrasp::seam {
namespace {

using base::kMm;
using base::YamlMap;

/// Thousandths of a second [s].
constexpr double kMs = 1e-3;

constexpr double kBaseColumns_1_m = 12'000.0;

void CheckTracker(bool good, const char* what) {
  if (!good) throw std::invalid_argument(fmt::format("edge tracker: {}", what));
}

/// The line may have too few columns for windows that suit the base sensor's.
void CheckSteps(const TrackerOptions& options) {
  const LocalStepOptions& steps = options.step_track.steps;
  CheckOptions(steps);
  const double narrowest = *std::ranges::min_element(steps.half_windows);
  const double least_1_m = kBaseColumns_1_m * kMinHalfWindow / narrowest;
  if (options.line.columns_per_m >= least_1_m) return;
  throw std::invalid_argument(fmt::format(
      "edge tracker: tracked steps (method steps) need {:.2f} columns a mm, the line has "
      "{:.2f}; use method voting or weights",
      least_1_m * kMm, options.line.columns_per_m * kMm));
}

void ReadFilter(YamlMap map, FilterOptions& options) {
  map.Read("half_width_columns", options.half_width_columns, 1, 512,
           "columns on each side in which a point looks for others");
  map.ReadScaled("half_height_mm", options.half_height_m, kMm, 0.001, 100.0,
                 "height above and below within which they count");
  map.Read(
      "min_neighbors", options.min_neighbors, 0, 1024,
      "a point with fewer others about it is dropped; fewer are asked of a profile with holes");
  map.Finish();
}

void ReadDetectors(YamlMap map, DetectorOptions& options) {
  map.Read("model_levels", options.model_fitting.levels,
           "which two heights the step of the model fitting has");
  map.Read("half_window_columns", options.local_weighted_voting.half_window, 1, 4096,
           "columns on each side that vote for a candidate (n of eq. 3.6)");
  map.Read("step_columns", options.local_weighted_voting.step_columns, 1, 4096,
           "columns on each side that tell a candidate's height (k of eq. 3.5)");
  map.Read("candidates", options.local_weighted_voting.candidates, 1, 4096,
           "columns that local weighted voting chooses from");
  map.Read(
      "kernel", options.gradient_accumulation.kernel, 0.001, 0.5,
      "half length of the largest gradient of gradient accumulation, as a share of the profile");
  map.Finish();
}

void ReadStep(YamlMap map, StepOptions& options) {
  map.Read("rule", options.rule,
           "how its height is measured: fit is by least squares over the millimetres beside it, "
           "range is as published");
  map.Read("fitted", options.fitted, 0.0, 1.0,
           "rule fit: share of min_step_mm from which a step is an edge's");
  map.Read("fitted_first", options.fitted_first, 0.0, 1.0,
           "rule fit: the same of a step that is not where the last ones were");
  map.ReadScaled("period_ms", options.period_s, kMs, 1.0, 10'000.0,
                 "rule fit: time over which profiles are averaged; an edge that moves by more than "
                 "a millimetre in it is smeared");
  map.Read("half_window_columns", options.half_window, 1, 512,
           "columns on each side of an edge in which its height is measured");
  map.Read("median_half_width_columns", options.median_half_width, 0, 512,
           "columns on each side that the median filter before it takes");
  map.Read("continued", options.continued, 0.0, 1.0,
           "rule range: share of min_step_mm that an edge needs where the last ones were; 1 is as "
           "published");
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.001, 100.0, "a lower step is no edge");
  map.Finish();
}

void ReadStepTrack(YamlMap map, StepTrackOptions& options) {
  map.ReadScaled("max_step_mm", options.steps.max_step_m, kMm, 0.001, 100.0,
                 "a higher step is no edge");
  map.ReadScaled("min_step_mm", options.min_step_m, kMm, 0.0, 100.0, "nor is a lower one");
  map.Read("memory", options.memory, 0.0, 0.999,
           "share of the evidence for an edge that each profile keeps");
  map.Read("speed_columns_per_s", options.speed_columns_per_s, 1.0, 1e6,
           "how fast an edge may be expected to move on the line (standard deviation)");
  map.Read("max_speed_columns_per_s", options.max_speed_columns_per_s, 1.0, 1e6,
           "and how fast at most");
  map.Read("evidence", options.evidence, 0.0, 1e6,
           "mean log-likelihood ratio over many profiles that makes an edge");
  map.Read("first_evidence", options.first_evidence, 0.0, 1e6,
           "what a single profile must have more; n profiles: an n-th of this");
  map.Read("most_evidence", options.most_evidence, 0.1, 1e6,
           "evidence that a profile counts for at most");
  map.Read("uneven", options.uneven, 0.01, 10.0,
           "share of its height by which an edge varies: the lower, the more a profile without it "
           "tells of a mat's end");
  map.Read("continued", options.continued, 0.0, 1.0,
           "share of the evidence that an edge needs to go on");
  map.Read("line_profiles", options.line_profiles, 2, 1000,
           "positions that the edge's line is laid through");
  map.Finish();
}

void ReadLinePrediction(YamlMap& map, LinePredictionOptions& options) {
  map.Read("line_inlier_columns", options.inlier_columns, 0.1, 1024.0,
           "distance to the predicting line within which a vote supports it");
  map.Read("line_max_slope_columns_per_s", options.max_slope_columns_per_s, 1.0, 1e6,
           "steeper predicting lines are not considered");
}

}  // namespace

void CheckOptions(const TrackerOptions& options) {
  CheckTracker(options.line.columns >= kMinColumns, "line.columns must be at least 32");
  CheckTracker(options.line.columns_per_m > 0.0, "line.columns_per_m must be above 0");
  CheckTracker(options.border_columns >= 0, "border_columns must not be negative");
  CheckTracker(options.vote_tolerance_m > 0.0, "vote_tolerance_m must be above 0");
  CheckTracker(options.packet_period_s > 0.0, "packet_period_s must be above 0");
  CheckTracker(options.refine_m >= 0.0, "refine_m must not be negative");
  CheckTracker(options.keep_m >= 0.0, "keep_m must not be negative");
  CheckTracker(options.line_prediction.inlier_columns > 0.0,
               "line_prediction.inlier_columns must be above 0");
  CheckTracker(options.line_prediction.max_slope_columns_per_s > 0.0,
               "line_prediction.max_slope_columns_per_s must be above 0");
  CheckTracker(options.history.length >= 1, "history.length must be at least 1");
  CheckTracker(options.history.sigma_columns > 0.0, "history.sigma_columns must be above 0");
  CheckTracker(options.accumulation.memory >= 0.0 && options.accumulation.memory < 1.0,
               "accumulation.memory must be at least 0 and below 1");
  CheckTracker(options.accumulation.spread_columns > 0.0,
               "accumulation.spread_columns must be above 0");
  if (options.method == DecisionMethod::kSteps) CheckSteps(options);
  CheckTracker(options.step.half_window >= 1, "step.half_window must be at least 1");
  CheckTracker(options.step.median_half_width >= 0, "step.median_half_width must not be negative");
  CheckTracker(options.step.continued >= 0.0 && options.step.continued <= 1.0,
               "step.continued must be from 0 to 1");
  CheckTracker(options.step.fitted >= 0.0 && options.step.fitted <= 1.0,
               "step.fitted must be from 0 to 1");
  CheckTracker(options.step.fitted_first >= 0.0 && options.step.fitted_first <= 1.0,
               "step.fitted_first must be from 0 to 1");
  CheckTracker(options.step.period_s > 0.0, "step.period_s must be above 0");
  CheckTracker(options.step.min_step_m > 0.0, "step.min_step_m must be above 0");
}

TrackerOptions WithWindowsOfLine(const TrackerOptions& options) {
  TrackerOptions scaled = options;
  const double scale = options.line.columns_per_m / kBaseColumns_1_m;
  const auto whole = [scale](int& columns) {
    columns = static_cast<int>(std::lround(scale * columns));
  };
  const auto at_least_one = [&](int& columns) {
    whole(columns);
    columns = std::max(columns, 1);
  };
  whole(scaled.border_columns);
  at_least_one(scaled.preprocess.filter.half_width_columns);
  whole(scaled.preprocess.filter.min_neighbors);
  at_least_one(scaled.detectors.local_weighted_voting.half_window);
  at_least_one(scaled.detectors.local_weighted_voting.step_columns);
  at_least_one(scaled.step.half_window);
  whole(scaled.step.median_half_width);
  scaled.line_prediction.inlier_columns *= scale;
  scaled.line_prediction.max_slope_columns_per_s *= scale;
  scaled.history.sigma_columns *= scale;
  scaled.accumulation.spread_columns *= scale;
  StepTrackOptions& track = scaled.step_track;
  for (int& half : track.steps.half_windows) whole(half);
  at_least_one(track.steps.stride);
  track.speed_columns_per_s *= scale;
  track.max_speed_columns_per_s *= scale;
  return scaled;
}

void ReadTrackerOptions(base::YamlMap& map, TrackerOptions& options) {
  map.Read("method", options.method, "how the position of a profile's edge is decided");
  map.ReadScaled(
      "columns_per_mm", options.line.columns_per_m, 1.0 / kMm, 0.1, 1000.0,
      "columns a millimetre of the line; a simulated sensor's own go before it. All windows in "
      "columns are stated for 12 and scaled to it");
  ReadFilter(map.Child("filter", "the geometric filter that drops single points"),
             options.preprocess.filter);
  map.Read("border_columns", options.border_columns, 0, 4096,
           "no edge is told this near to the first and the last measured column");
  map.Read("normalise", options.preprocess.normalise,
           "whether a parabola is subtracted from each profile");
  map.Read("min_columns", options.preprocess.min_columns, 8, 65536,
           "a profile with fewer points after the filter is unusable");
  ReadDetectors(map.Child("detectors", "the three detectors"), options.detectors);
  map.ReadScaled("vote_tolerance_mm", options.vote_tolerance_m, kMm, 0.01, 100.0,
                 "two detectors agree if their positions are this near to each other");
  map.ReadScaled("packet_period_ms", options.packet_period_s, kMs, 1.0, 10'000.0,
                 "time between two packets to the robot");
  map.ReadScaled("refine_mm", options.refine_m, kMm, 0.0, 100.0,
                 "a packet tells where a step fits best to its profiles, this near to what was "
                 "decided; 0: what was decided");
  map.ReadScaled("keep_mm", options.keep_m, kMm, 0.0, 100.0,
                 "what was decided is sent if it is this near to where the step fits best");
  map.Read("confirm", options.confirm,
           "whether a step counts only if another of the last profiles shows it, too");
  ReadLinePrediction(map, options.line_prediction);
  map.Read("history_length", options.history.length, 1, 1000,
           "earlier positions that raise the weights near them (n of eq. 3.19)");
  map.Read("history_sigma_columns", options.history.sigma_columns, 0.5, 4096.0,
           "width of the bell by which they do");
  map.Read("memory", options.accumulation.memory, 0.0, 0.999,
           "method accumulated: share of the sum of weights that each profile keeps");
  map.Read("spread_columns", options.accumulation.spread_columns, 0.1, 1024.0,
           "method accumulated: width of the bell that a candidate's weight is spread over");
  ReadStep(map.Child("step", "the height of a step, which tells whether there is an edge"),
           options.step);
  ReadStepTrack(map.Child("step_track", "method steps"), options.step_track);
  map.Read("positive_edge", options.positive_edge,
           "whether the edge rises with the column number; false: it falls");
}

}  // namespace rangegrasp::seam
