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

/// Two out of three (dissertation, section 3.4): the mean of the closest two positions, if they lie
/// within the tolerance; ties go to the pair that is listed first.
std::optional<double> VoteTwoOfThree(const std::array<std::optional<int>, kDetectors>& columns,
                                     double tolerance_columns);

/// A position found at a time.
struct TimedColumn {
  double time_s;
  double column;
};
/// The least-squares line through some positions; level if all have one time.
struct TimedLine {
  double time_s;  ///< where it goes through `column`
  double column;
  double slope;

  double At(double t) const { return column + slope * (t - time_s); }
};
TimedLine FitLine(std::span<const TimedColumn> positions);

struct LinePredictionOptions {
  /// > 0; half a millimetre of the base sensor: wider lets in fibres next to the edge, narrower
  /// leaves out votes of a frayed one.
  double inlier_columns = 6.0;
  /// > 0; 50 mm/s across at 12 columns a mm; an edge at 45 degrees moves by 30 mm/s before a head
  /// of that speed.
  double max_slope_columns_per_s = 600.0;
};
struct LinePrediction {
  double column;
  int inliers;  ///< positions that the line rests on
};
/// RANSAC line fit (Fischler and Bolles 1981; section 3.4) over the positions of the last 100 ms
/// and the last one sent, evaluated at `time_s`. Every pair of points is tried, so that nothing is
/// random (of more than 16, which a sensor of 150 Hz and more brings, of 16 that are spread over
/// them): the line with most inliers wins (ties: least squared error, then order), and is refitted
/// to them. One point: that point. O(points).
std::optional<LinePrediction> PredictByLine(std::span<const TimedColumn> found, double time_s,
                                            const LinePredictionOptions& options);

/// Sum of the detectors' normalised weight functions (eq. 3.16).
std::vector<float> SumOfWeights(const std::array<DetectorResult, kDetectors>& results);

/// Each column's weight falls off on both sides as a bell; where bells meet the higher one counts.
std::vector<float> SpreadWeights(const std::vector<float>& weight, double sigma_columns);

struct HistoryOptions {
  int length = 10;  ///< n of eq. 3.19, >= 1: as many as the sensor takes in 100 ms at 100 Hz
  /// > 0, of the bell curve (eq. 3.18, which leaves it open): wider holds on to an edge less
  /// firmly, narrower loses one that moves on the line while the head turns.
  double sigma_columns = 20.0;
};
/// Bell curve round x1 (eq. 3.18).
double Bell(double x, double x1, double sigma);
/// W_h (eq. 3.20): W(i) [1 + 1/(n(n+1)) sum_t t bell(h(t) - i)]; h oldest first. Since the t sum to
/// n(n+1)/2, history adds at most half of the current weight.
void WeightByHistory(std::span<float> weight, std::span<const double> history,
                     double sigma_columns);

/// How the height of a step is measured.
enum class StepRule {
  kRange,  ///< the range of the smoothed heights about it (section 3.5.3)
  kFit,    ///< a least-squares fit of a parabola and a step (StepTest)
};
constexpr std::array<std::string_view, 2> WordsOf(StepRule) { return {"range", "fit"}; }

struct StepOptions {
  StepRule rule = StepRule::kFit;
  /// Of kFit. A fit is off by a tenth of a millimetre at most; a range has noise added to it.
  double fitted = 0.6;
  /// Of kFit. A noisy surface without an edge has some of 0.6 in a tenth of a second's profiles.
  double fitted_first = 0.8;
  double period_s = 0.1;      ///< > 0, of kFit: three profiles at least
  int half_window = 10;       ///< >= 1 [columns] (section 3.5.3)
  int median_half_width = 6;  ///< >= 0 [columns]; one as wide as the window flattens slanted edges
  /// Of kRange: an edge of a mat as thin as min_step_m is not lost to noise in every other profile.
  /// 1: as published.
  double continued = 0.7;
  double min_step_m = 0.3e-3;  ///< > 0; the thinnest mat (section 3.5.3)
};
/// Step height round a column (section 3.5.3): the heights within the half window are smoothed by a
/// median filter; the step is their maximum less their minimum. 0 outside of the profile.
double StepHeight(std::span<const float> f, int column, const StepOptions& options);

/// How high the step at a place of a line is: the least-squares fit of a parabola and a step there,
/// over the medians of short stretches next to it, averaged over the last profiles. The fibres and
/// the noise of single columns that decide about the range of heights within a millimetre hardly
/// move it. Voting and weights use it where their detectors see a step. The fit of
/// seam/step_track.h, which looks at all places with windows of four widths, takes some 28 us a
/// profile and this 2, so that both stay.
class StepTest {
 public:
  /// @param period_s  > 0; the profiles of so long are averaged, three at least.
  explicit StepTest(const LineGeometry& line, double period_s = StepOptions{}.period_s);

  /// Takes the next profile; an unusable one tells nothing, but time goes on.
  void Take(const PreparedProfile& profile);
  /// Height of the step at a column [m]: the highest within a block. Nothing where fewer than 3 mm
  /// of the line have been measured on either side.
  std::optional<double> HeightAt(double column);
  /// The column within a distance where a step fits best, if one fits at all.
  std::optional<double> Locate(double column, double within_columns);
  /// Time of the middle one of the profiles that are averaged; there must have been one.
  double MiddleTime() const { return recent_[recent_.size() / 2].time_s; }

 private:
  struct Blocks {
    double time_s;
    int first;                    // of those that lie within what was measured
    std::vector<float> height_m;  // the middle ones of each block's columns
  };
  // Blocks whose weighted sum is the height of a step, and how sure that is: 1 over its standard
  // deviation, in those of a block.
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

  int columns_;  // of a block
  double period_s_;
  std::vector<float> heights_;  // of the blocks, to sort them
  std::deque<Blocks> recent_;
  Blocks mean_{};
  std::map<std::array<int, 3>, Kernel> kernels_;
};

/// Where between its neighbors a greatest value has its summit, by the parabola through the three:
/// from -0.5 to 0.5 of their distance.
inline double SummitOffset(double before, double greatest, double after) {
  const double bend = before - 2.0 * greatest + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace rangegrasp::seam
