#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "seam/decision.h"

namespace rangegrasp::seam {

/// Fewer columns on each side tell no step from a bend.
inline constexpr int kMinHalfWindow = 4;

/// The fourth detector, our own: at each place a parabola with a step is fitted by least squares to
/// the measured points of a window, in windows of several widths. Narrow windows are not misled by
/// a wavy surface, wide ones see through noise and holes.
struct LocalStepOptions {
  /// >= kMinHalfWindow [columns]: 3, 8, 25 and 43 mm of the base sensor.
  std::array<int, 4> half_windows = {36, 96, 300, 516};
  int stride = 3;              ///< >= 1 [columns] between two places: a quarter of a millimetre
  double max_step_m = 2.5e-3;  ///< > 0; a higher step is an obstacle (section 3.7: 3 mm)
};

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
/// Rohling 1983). Where doubt is left and an edge would lie in the windows of many places, the step
/// that fits best is first taken off there.
/// @param height_m  heights as measured, NaN where there is none. O(columns).
std::vector<LocalStep> FitLocalSteps(std::span<const float> height_m,
                                     const LocalStepOptions& options = {});

/// The texts of the keys of `step_track` say what each is.
struct StepTrackOptions {
  LocalStepOptions steps;
  double memory = 0.9;  ///< in [0, 1)
  /// > 0: a profile whose greatest evidence is above this has all of it scaled down to this, so
  /// that an edge that ends is soon forgotten.
  double most_evidence = 15.0;
  double uneven = 0.2;                     ///< > 0
  double speed_columns_per_s = 240.0;      ///< > 0; 20 mm/s at 12 columns a mm
  double max_speed_columns_per_s = 600.0;  ///< > 0
  double min_step_m = 0.15e-3;             ///< >= 0: half of the thinnest mat
  /// Of very many profiles, and what one profile alone must have more. Without an edge the best
  /// place has 1.7 (99.5 %: 2.8 to 3.6), and 5 (99.5 %: 6 to 15).
  double evidence = 3.6;
  double first_evidence = 9.0;
  double continued = 0.6;  ///< in [0, 1]
  int line_profiles = 10;  ///< >= 2
};

/// Tracks a step before it is detected: the evidence of each place is added up along the likeliest
/// ways over the profiles (dynamic programming; Barniv 1985), and only the sum is judged.
class StepTrack {
 public:
  /// What the profiles so far tell.
  struct Estimate {
    std::optional<double> column;  ///< of the edge; none: there is none
    /// What is reported to a head. As column, but where this profile alone has evidence enough for
    /// an edge elsewhere it is nothing, or that place if the profile before had it, too: ways keep
    /// to the old place for six profiles after a corner.
    std::optional<double> at_once;
    std::optional<int> strongest;  ///< the place with the greatest evidence in this profile
    double step_m = 0.0;           ///< mean along the best way
    double evidence = 0.0;         ///< mean along the best way
    /// Whether there was an edge and the last profiles have a step of its height where it has been:
    /// the evidence of many profiles outlives a mat's end, and noise elsewhere may take it over.
    bool goes_on = false;
    double followed_step_m = 0.0;  ///< its height then, also where column is none
    bool sure = false;             ///< whether the last profiles left no doubt of the known edge
  };
  explicit StepTrack(const StepTrackOptions& options);
  /// @param height_m  as measured, NaN where there is none; as many at each call.
  /// @param moved_columns  by how much the line moved along itself since the call before.
  Estimate Update(std::span<const float> height_m, double time_s, double moved_columns = 0.0);

 private:
  // Sums along the likeliest way to a place, of which each profile forgets a share.
  struct Way {
    double evidence = 0.0;
    double height = 0.0;  // of precision times height
    double precision = 0.0;

    double Height() const { return precision > 0.0 ? height / precision : 0.0; }
  };
  // An edge that is known: where and how high it is, and the odds that it is still there.
  struct Known {
    double column, height_m;
    double log_odds;
    int profiles = 0;   // that the height is of
    int elsewhere = 0;  // profiles in a row with surer evidence elsewhere
    int sure = 0;       // profiles in a row without doubt
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
  std::vector<Way> ways_;  // to each place
  double weight_ = 0.0;    // of a Way's sums: 1 + memory + memory^2 ...
  bool edge_ = false;
  double moved_places_ = 0.0;  // of the line, not yet taken over by the ways
  std::optional<Known> known_;
  bool was_sure_ = false;
  bool gone_ = false;  // nothing was left of the edge that was sure, and none has been sure since
  std::optional<double> alone_;  // where the profile before had an edge by itself
  std::optional<double> last_time_s_;
  std::deque<TimedColumn> positions_;  // of the last profiles
};

}  // namespace rangegrasp::seam
