#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "seam/detectors.h"
#include "seam/profile.h"

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

struct LinePredictionOptions {
  /// > 0; half a millimetre with the base sensor. A larger value accepts fibres next to the edge, a
  /// smaller one rejects votes for a frayed edge.
  double inlier_columns = 6.0;
  /// > 0; a lateral speed of 50 mm/s at 12 columns per mm. An edge at 45 degrees moves laterally at
  /// 30 mm/s in front of a head of that speed.
  double max_slope_columns_per_s = 600.0;
};
struct LinePrediction {
  double column;
  int inliers;  ///< number of positions that support the line
};
/// RANSAC line fit (Fischler and Bolles 1981; section 3.4) to the positions of the last 100 ms and
/// the last one sent, evaluated at `time_s`. All pairs of points are tried, so the result is
/// deterministic. Of more than 16 points (sensors of 150 Hz and more), 16 evenly spread ones form
/// the pairs. The line with the most inliers wins (ties: smallest squared error, then order) and is
/// refitted to its inliers. With one point, the result is that point. O(points).
std::optional<LinePrediction> PredictByLine(std::span<const TimedColumn> found, double time_s,
                                            const LinePredictionOptions& options);

/// Sum of the detectors' normalised weight functions (eq. 3.16).
std::vector<float> SumOfWeights(const std::array<DetectorResult, kDetectors>& results);

/// Spreads each column's weight by a bell curve; where curves overlap, the higher one counts.
std::vector<float> SpreadWeights(const std::vector<float>& weight, double sigma_columns);

struct HistoryOptions {
  int length = 10;  ///< n of eq. 3.19, >= 1: number of profiles in 100 ms at 100 Hz
  /// > 0; sigma of the bell curve (eq. 3.18 does not specify it). A larger value holds an edge less
  /// firmly, a smaller one loses an edge that moves along the line while the head turns.
  double sigma_columns = 20.0;
};
/// Bell curve about x1 (eq. 3.18).
double Bell(double x, double x1, double sigma);
/// W_h (eq. 3.20): W(i) [1 + 1/(n(n+1)) sum_t t bell(h(t) - i)]; h is oldest first. The sum of all
/// t is n(n+1)/2, so history adds at most half of the current weight.
void WeightByHistory(std::span<float> weight, std::span<const double> history,
                     double sigma_columns);

/// How the height of a step is measured.
enum class StepRule {
  kRange,  ///< range of the smoothed heights around it (section 3.5.3)
  kFit,    ///< least-squares fit of a parabola and a step (StepTest)
};
constexpr std::array<std::string_view, 2> WordsOf(StepRule) { return {"range", "fit"}; }

struct StepOptions {
  StepRule rule = StepRule::kFit;
  /// For kFit. The error of a fit is at most 0.1 mm, whereas noise adds to a range.
  double fitted = 0.6;
  /// For kFit, a new edge. A noisy surface without an edge has some steps of 0.6 in 0.1 s.
  double fitted_first = 0.8;
  double period_s = 0.1;       ///< > 0, for kFit: at least three profiles
  int half_window = 10;        ///< >= 1 [columns] (section 3.5.3)
  int median_half_width = 6;   ///< >= 0 [columns]; one as wide as the window flattens slanted edges
  double min_step_m = 0.3e-3;  ///< >= 0; the thinnest mat (section 3.5.3); 0: no test
};
/// Step height at a column (section 3.5.3): maximum minus minimum of the median-filtered heights
/// within the half window. 0 outside the profile.
double StepHeight(std::span<const float> f, int column, const StepOptions& options);

/// Measures the height of a step at a column: a least-squares fit of a parabola and a step to the
/// medians of short blocks on both sides, averaged over the last profiles. Fibres and single-column
/// noise, which dominate the range of heights within a millimetre, hardly affect it. Voting and
/// weights use it where their detectors see a step. The fit of seam/step_track.h looks at all
/// places with windows of four widths and takes about 28 us per profile; this one takes 2 us, so
/// both are kept.
class StepTest {
 public:
  /// @param period_s  > 0; the profiles of this period are averaged, at least three.
  explicit StepTest(const LineGeometry& line, double period_s = StepOptions{}.period_s);

  /// Takes the next profile. An unusable one is ignored, but it makes the others older: only the
  /// last three profiles and those of the period are averaged.
  void Take(const PreparedProfile& profile);
  /// Height of the step at a column [m]: the highest within one block of it. Nothing if less than 3
  /// mm of the line were measured on either side.
  std::optional<double> HeightAt(double column);
  /// The column within a distance of `column` where a step fits best, if any step fits.
  std::optional<double> Locate(double column, double within_columns);
  /// Time of the middle averaged profile. The last profile taken must have been usable.
  double MiddleTime() const { return recent_[recent_.size() / 2].time_s; }

 private:
  struct Blocks {
    double time_s;
    int first;                    // index of the first one within the measured columns
    std::vector<float> height_m;  // median of each block's columns
  };
  // Weights of blocks, whose weighted sum is the height of a step, and the certainty of this
  // height: 1 / standard deviation, in units of a block's standard deviation.
  struct Kernel {
    std::vector<float> weights;
    double certainty = 0.0;
  };
  struct Fit {
    double height_m, certainty;
  };
  void Average();
  std::optional<Fit> FitBefore(int block, int gap);
  const Kernel& KernelOf(int left, int right, int gap);

  int columns_;  // columns per block
  double period_s_;
  std::deque<double> times_;  // of the last three profiles, usable or not
  std::deque<Blocks> recent_;
  Blocks mean_{};
  std::map<std::array<int, 3>, Kernel> kernels_;
};

/// Offset of the peak from a maximum, by the parabola through it and its neighbors: from -0.5 to
/// 0.5 of their spacing.
inline double SummitOffset(double before, double greatest, double after) {
  const double bend = before - 2.0 * greatest + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace rangegrasp::seam
