#pragma once

#include <array>
#include <span>
#include <vector>

namespace rangegrasp::seam {

/// Fewer columns on each side tell no step from a bend.
inline constexpr int kMinHalfWindow = 4;

/// The fourth detector, our own: at each place a parabola with a step is fitted by least squares to
/// the measured points of a window, in windows of several widths. Narrow windows are not misled by
/// a wavy surface, wide ones see through noise and holes.
struct LocalStepOptions {
  /// >= kMinHalfWindow, half widths of the windows [columns]: 3, 8, 25 and 43 mm of the base
  /// sensor.
  std::array<int, 4> half_windows = {36, 96, 300, 516};
  int stride = 3;  ///< >= 1 [columns] between two places: a quarter of a millimetre
  /// > 0; a higher step is an obstacle (section 3.7: 3 mm), no mat's edge.
  double max_step_m = 2.5e-3;
};

/// @throws std::invalid_argument naming the option that is out of range.
void CheckOptions(const LocalStepOptions& options);

/// What the points about one place say.
struct LocalStep {
  /// Log-likelihood ratio of the parabola with a rising step to the parabola without, in the window
  /// that tells most; 0: nothing speaks for a step.
  double evidence = 0.0;
  double height_m = 0.0;      ///< of the step
  double precision_m2 = 0.0;  ///< 1 / variance of height_m
  /// Height by the window that knows it best, also where it is 0 or less: tells that there is none.
  double surest_height_m = 0.0;
  double surest_precision_m2 = 0.0;  ///< 0: no window fits
};

/// Steps at the columns 0, stride, 2 stride, ...: from there on the points belong to the high side.
/// Points are first replaced by the median of the nine about them, which takes out filaments and
/// reflections. Residuals of a real surface are not independent: what likelihoods claim too much is
/// measured in the profile itself, by the 25 % quantile of the squared t-values of all places
/// against that of the chi-squared distribution (as a radar keeps its rate of false alarms;
/// Rohling 1983). Where the evidence leaves doubt and an edge would lie in the windows of many
/// places, the step that fits best is first taken off there.
/// @param height_m  heights as measured, NaN where there is none. O(columns).
/// @throws std::invalid_argument if an option is out of range.
std::vector<LocalStep> FitLocalSteps(std::span<const float> height_m,
                                     const LocalStepOptions& options = {});

}  // namespace rangegrasp::seam
