#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/published.h"

namespace rangegrasp::experiment {

enum class Verdict {
  kBetter,
  kSame,  ///< no difference is shown: few trials show none
  kWorse,
  kNoFigure,  ///< nothing was counted, e.g. no grasp of an object that was never detected
};
constexpr std::array<std::string_view, 4> WordsOf(Verdict) {
  return {"better", "same", "worse", "no figure"};
}

/// A computer of today takes less than a tenth of the published 2 GHz Core 2 Duo's time for the
/// same program on one core (PassMark's single-thread ratings: about 5000 and 800): only what is
/// faster by more than this is better, and what is slower is worse.
inline constexpr double kComputersFactor = 10.0;

/// A published figure beside the own one, and what the difference means.
struct Judged {
  PublishedFigure figure;
  std::string counts;       ///< what the test compares: "47 of 50, published 9 of 10"
  std::optional<double> p;  ///< two-sided; absent where nothing is tested
  Verdict verdict = Verdict::kNoFigure;
};

struct JudgedTable {
  std::vector<Judged> rows;
  double threshold = 0.0;  ///< of p: 0.05 over the number of tests (Bonferroni); 0 without any
  std::vector<std::string> tests;  ///< the tests that the rows' verdicts rest on, in words
};

/// The verdict of each row; all rows together are wrong by chance in 5 % of tables at most.
JudgedTable Judge(const std::vector<PublishedFigure>& figures);

}  // namespace rangegrasp::experiment
