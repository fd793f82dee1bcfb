#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "seam/decision.h"

namespace rangegrasp::seam {

/// With fewer columns on each side, a step cannot be distinguished from a bend.
inline constexpr int kMinHalfWindow = 4;

/// The fourth detector, our own: least-squares fits of a parabola with a step at each place, in
/// windows of several widths: narrow ones for wavy surfaces, wide ones for noise and holes.
struct LocalStepOptions {
  /// >= kMinHalfWindow [columns]: 3, 8, 25 and 43 mm with the base sensor.
  std::array<int, 4> half_windows = {36, 96, 300, 516};
  int stride = 3;              ///< >= 1 [columns] between two places: a quarter of a millimetre
  double max_step_m = 2.5e-3;  ///< > 0; a higher step is an obstacle (section 3.7: 3 mm)
};

/// Result of the fits at one place.
struct LocalStep {
  /// Log-likelihood ratio of the parabola with a rising step to the parabola without, in the window
  /// where it is highest; 0: no evidence of a step.
  double evidence = 0.0;
  double height_m = 0.0;      ///< of the step
  double precision_m2 = 0.0;  ///< 1 / variance of height_m
  /// Height in the window of highest precision; 0 or less means that there is no step.
  double surest_height_m = 0.0;
  double surest_precision_m2 = 0.0;  ///< 0: no window fits
};

/// Fits steps at the columns 0, stride, 2 stride, ..., where the high side begins. A median of nine
/// points first removes filaments and reflections. Residuals of a real surface are correlated, so
/// likelihoods are too confident. The factor is estimated from the profile: the 25 % quantile of
/// the squared t-values of all places over that of the chi-squared distribution (like the constant
/// false-alarm rate of a radar; Rohling 1983). If no step is beyond doubt and an edge would lie in
/// the windows of many places, the best-fitting step is subtracted first.
/// @param height_m  heights as measured, NaN where there is none. O(columns).
std::vector<LocalStep> FitLocalSteps(std::span<const float> height_m,
                                     const LocalStepOptions& options = {});

struct StepTrackOptions {
  LocalStepOptions steps;
  double memory = 0.9;  ///< share of the evidence that is kept from profile to profile
  /// Variation of an edge's height, relative to the height: the lower, the more a profile without
  /// an edge indicates a mat's end.
  double uneven = 0.2;
  double speed_columns_per_s = 240.0;      ///< > 0; 20 mm/s at 12 columns per mm
  double max_speed_columns_per_s = 600.0;  ///< > 0
  double min_step_m = 0.15e-3;             ///< >= 0: half of the thinnest mat
  /// Evidence required of very many profiles, and what a single profile needs in addition. Without
  /// an edge the best place has 1.7 (99.5 %: 2.8 to 3.6) and 5 (99.5 %: 6 to 15), respectively.
  double evidence = 3.6;
  double first_evidence = 9.0;
  double continued = 0.6;  ///< share of the required evidence at which a found edge is continued
  int line_profiles = 10;  ///< number of positions to which the edge's line is fitted
};

/// Track-before-detect of a step: the evidence of each place is summed along the most likely paths
/// ("ways") over the profiles (dynamic programming; Barniv 1985), and only the sum is tested.
class StepTrack {
 public:
  /// Estimate from the profiles so far.
  struct Estimate {
    std::optional<double> column;  ///< of the edge; none: there is no edge
    /// Position to report to a head. It is `column`, unless this profile alone has enough evidence
    /// for an edge elsewhere: then it is none, or that place if the previous profile had it, too.
    /// Ways stay at the old place for six profiles after a corner.
    std::optional<double> at_once;
    std::optional<int> strongest;  ///< column with the greatest evidence in this profile
    double step_m = 0.0;           ///< mean along the best way
    /// True if the last profiles have a step of the known edge's height at its place: the evidence
    /// of many profiles outlives a mat's end.
    bool goes_on = false;
    double followed_step_m = 0.0;  ///< its height if goes_on, even if column is none
    bool sure = false;             ///< whether the last profiles show the known edge beyond doubt
  };
  explicit StepTrack(const StepTrackOptions& options);
  /// @param height_m  as measured, NaN where there is none; the same number at each call.
  /// @param moved_columns  motion of the line along itself since the previous call.
  Estimate Update(std::span<const float> height_m, double time_s, double moved_columns = 0.0);

 private:
  // Sums along the most likely way to a place, which decay from profile to profile.
  struct Way {
    double evidence = 0.0;
    double height = 0.0;  // sum of precision times height
    double precision = 0.0;

    double Height() const { return precision > 0.0 ? height / precision : 0.0; }
  };
  // The known edge: its position and height, and the log-odds that it is still there.
  struct Known {
    double column, height_m;
    double log_odds;
    int profiles = 0;   // number of profiles in the height
    int elsewhere = 0;  // consecutive profiles with sufficient evidence elsewhere
    int sure = 0;       // consecutive profiles without doubt
  };
  void MoveLine(double columns);
  std::vector<Way> Moved(int shift, double period_s) const;
  void Continue(const std::vector<LocalStep>& steps, double strongest, double period_s);
  bool Suffices(const Way& way, double share) const;
  double Peak(std::size_t place) const;
  double OnLine(double column, double time_s);
  std::optional<double> AtOnce(std::optional<double> column, const LocalStep& strongest,
                               double place);
  void Follow(double column, const Way& way, double period_s);
  void Weigh(const LocalStep& step);
  bool IsSure(double column, const Way& way, const LocalStep& there);

  StepTrackOptions options_;
  std::vector<Way> ways_;  // one per place
  double weight_ = 0.0;    // total weight in a Way's sums: 1 + memory + memory^2 ...
  bool edge_ = false;
  double moved_places_ = 0.0;  // motion of the line that is not yet applied to the ways
  std::optional<Known> known_;
  bool was_sure_ = false;
  bool gone_ = false;            // the sure edge disappeared, and none has been sure since
  std::optional<double> alone_;  // where the previous profile alone had an edge
  std::optional<double> last_time_s_;
  std::deque<TimedColumn> positions_;  // of the last profiles
};

}  // namespace rangegrasp::seam
