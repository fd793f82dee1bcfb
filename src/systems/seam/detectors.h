#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace rangegrasp::seam {

/// The three complementary detectors (dissertation, section 3.3), for a positive step edge: low at
/// small columns, high at large ones. They take a prepared profile: m finite heights [m].
enum class Detector { kModelFitting, kLocalWeightedVoting, kGradientAccumulation };
constexpr int kDetectors = 3;
/// Names as in tables 3.1 to 3.3.
constexpr std::array<std::string_view, kDetectors> WordsOf(Detector) {
  return {"Model-Fitting", "Local Weighted-Voting", "Gradient-Accumulation"};
}

struct DetectorResult {
  /// The edge: first column of the high side; none if m is too small or the profile is flat.
  std::optional<int> column;
  std::vector<float> weight;  ///< m values in [0, 1]: eq. 3.13, 3.14 or 3.15
};

/// Global least-squares fit of a step (eq. 3.1-3.4), in O(m) by running sums. The two levels h
/// (eq. 3.1) are "the minimum and maximum pixel" of the whole profile. All columns are evaluated:
/// section 3.3.1 does not describe its "prediction of possible edge candidates".
DetectorResult FitEdgeModel(std::span<const float> f);

/// The columns with the greatest nonzero |f(j+1) - f(j)|, at most `candidates`, greatest first
/// (ties: smaller column first). The candidate is j+1, the first column of the step's far side.
std::vector<int> EdgeCandidates(std::span<const float> f, int candidates);
/// Votes of the neighborhood for each of 30 candidates (eq. 3.5-3.9). weight is 0 at all other
/// columns. Windows are truncated at the profile's ends.
DetectorResult VoteLocally(std::span<const float> f);

/// Sum of gradient magnitudes over growing kernels, up to a tenth of the profile (eq. 3.12). The
/// end values are repeated beyond the ends. O(m * kernel).
DetectorResult AccumulateGradients(std::span<const float> f);

std::array<DetectorResult, kDetectors> DetectEdges(std::span<const float> f);

}  // namespace rangegrasp::seam
