#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "seam/decision.h"
#include "seam/local_step.h"

namespace rangegrasp::seam {

struct StepTrackOptions {
  LocalStepOptions steps;
  double memory = 0.9;  ///< in [0, 1): share of the evidence that each profile keeps
  /// > 0: a profile whose greatest evidence is above this has all of it scaled down to this, so
  /// that an edge that ends is soon forgotten.
  double most_evidence = 15.0;
  /// > 0: share of its height by which an edge varies (standard deviation). A profile that surely
  /// has no step speaks against the edge with 1 / (2 uneven^2).
  double uneven = 0.2;
  /// > 0, how fast an edge may be expected to move on the line: standard deviation. 20 mm/s at 12
  /// columns a mm.
  double speed_columns_per_s = 240.0;
  double max_speed_columns_per_s = 600.0;  ///< > 0
  double min_step_m = 0.15e-3;             ///< >= 0: half of the thinnest mat
  /// Evidence a profile that makes an edge: of very many profiles, and what one profile alone must
  /// have more (of n a n-th of it). Without an edge the best place has 1.7 (99.5 %: 2.8 to 3.6),
  /// and 5 (99.5 %: 6 to 15).
  double evidence = 3.6;
  double first_evidence = 9.0;
  double continued = 0.6;  ///< in [0, 1]: share of them that an edge needs to go on
  int line_profiles = 10;  ///< >= 2: positions that the edge's line is laid through
  double forget_s = 1.0;   ///< > 0: after a longer gap nothing is known
};

/// Tracks a step before it is detected: the evidence of each place is added up along the likeliest
/// ways over the profiles (dynamic programming; Barniv 1985), and only the sum is judged.
class StepTrack {
 public:
  /// What the profiles so far tell.
  struct Estimate {
    std::optional<double> column;  ///< of the edge; none: there is none
    std::optional<int> strongest;  ///< the place with the greatest evidence in this profile
    double step_m = 0.0;           ///< mean along the best way
    double evidence = 0.0;         ///< mean along the best way
    /// Whether the edge goes on where profiles without its step speak against it as much as those
    /// with it speak for it. Else the evidence of many profiles outlives a mat's end.
    bool goes_on = false;
  };
  /// @throws std::invalid_argument if an option is out of range.
  explicit StepTrack(const StepTrackOptions& options);
  /// @param height_m  as measured, NaN where there is none; as many at each call.
  Estimate Update(std::span<const float> height_m, double time_s);

 private:
  // Sums along the likeliest way to a place, of which each profile forgets a share.
  struct Way {
    double evidence = 0.0;
    double height = 0.0;  // of precision times height
    double precision = 0.0;

    double Height() const { return precision > 0.0 ? height / precision : 0.0; }
  };
  struct Ways {
    std::vector<Way> to;  // each place
    bool edge = false;
  };
  double Absence(const Way& way, const LocalStep& step) const;
  std::vector<Way> Moved(const std::vector<Way>& ways, double period_s) const;
  void Continue(const std::vector<LocalStep>& steps, double strongest, double period_s);
  const Way& Judge(Ways& ways) const;
  double Peak(std::size_t place) const;
  double OnLine(double column, double time_s);

  StepTrackOptions options_;
  Ways ways_;            // tell where the edge is
  Ways strict_;          // and whether it goes on
  double weight_ = 0.0;  // of a Way's sums: 1 + memory + memory^2 ...
  std::optional<double> last_time_s_;
  std::deque<TimedColumn> positions_;  // of the last profiles
};

}  // namespace rangegrasp::seam
