#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "seam/preprocess.h"
#include "seam/profile.h"

namespace rangegrasp::seam {

struct StepTestOptions {
  double block_m = 0.5e-3;  ///< > 0; medians of stretches of this length are compared
  double reach_m = 10e-3;   ///< of the line, on each side of a place, that tells its step
  /// Left out on each side: what frays, and half of a slant of 2 mm but for what the rest
  /// outweighs.
  double gap_m = 0.5e-3;
  double period_s = 0.1;  ///< > 0; the profiles of so long are averaged, three at least
};

/// How high the step at a place of a line is, by all that lies beside it: the least-squares fit of
/// a parabola and a step there, over the medians of short stretches, averaged over the last
/// profiles. The fibres and the noise of single columns that decide about the range of heights
/// within a millimetre hardly move it.
/// Voting and weights use it where their detectors see a step. The fit of seam/local_step.h, which
/// looks at all places with windows of four widths, takes some 28 us a profile and this 2, so that
/// both stay.
class StepTest {
 public:
  explicit StepTest(const LineGeometry& line, const StepTestOptions& options = {});

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

  int columns_, reach_, gap_;  // of a block; [blocks]
  double period_s_;
  std::vector<float> heights_;  // of the blocks, to sort them
  std::deque<Blocks> recent_;
  Blocks mean_{};
  std::map<std::array<int, 3>, Kernel> kernels_;
};

}  // namespace rangegrasp::seam
