#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "seam/detectors.h"

namespace rangegrasp::seam {

/// Two-out-of-three vote (dissertation, section 3.4): the mean of the two closest positions if they
/// lie within the tolerance. In a tie the first pair wins.
std::optional<double> VoteTwoOfThree(const std::array<std::optional<int>, kDetectors>& columns,
                                     double tolerance_columns);

struct TimedColumn {
  double time_s;
  double column;
};
/// Least-squares line through positions over time; slope 0 if all have the same time.
struct TimedLine {
  double time_s;  ///< time at which the line passes through `column`
  double column;
  double slope;

  double At(double t) const { return column + slope * (t - time_s); }
};
TimedLine FitLine(std::span<const TimedColumn> positions);

/// RANSAC line fit (Fischler and Bolles 1981; section 3.4) to the positions of the last 100 ms and
/// the last one sent, evaluated at `time_s`. The pairs of all points, or of 16 evenly spread ones,
/// are tried, so the result is deterministic. The line with the most inliers wins (ties: smallest
/// squared error, then order) and is refitted to them. One point gives that point. O(points).
/// @param inlier_columns  > 0; maximum distance of an inlier from the line
std::optional<double> PredictByLine(std::span<const TimedColumn> found, double time_s,
                                    double inlier_columns);

/// Sum of the detectors' normalised weight functions (eq. 3.16).
std::vector<float> SumOfWeights(const std::array<DetectorResult, kDetectors>& results);

/// Bell curve about x1 (eq. 3.18).
double Bell(double x, double x1, double sigma);
/// W_h (eq. 3.20): W(i) [1 + 1/(n(n+1)) sum_t t bell(h(t) - i)]; h is oldest first. The sum of all
/// t is n(n+1)/2, so history adds at most half of the current weight.
void WeightByHistory(std::span<float> weight, std::span<const double> history,
                     double sigma_columns);

/// Step height at a column (section 3.5.3): maximum minus minimum of the median-filtered heights
/// within 10 columns of it. 0 outside the profile.
double StepHeight(std::span<const float> f, int column);

}  // namespace rangegrasp::seam
