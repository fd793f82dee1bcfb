#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::experiment {

/// Cases of the same id and seed in two runs, compared pairwise.
struct Comparison {
  int pairs = 0;
  int both = 0;  ///< succeeded in both
  int only_first = 0;
  int only_second = 0;
  int same_outcome = 0;
  double p_value = 1.0;  ///< McNemar's exact test of only_first against only_second
};
/// @param success  the outcome that counts as one
Comparison Compare(const std::vector<Record>& first, const std::vector<Record>& second,
                   const std::string& success);

/// Positions (in first, in second) of the pairs of which one succeeded and the other did not, in
/// the order of second.
std::vector<std::pair<std::size_t, std::size_t>> Differing(const std::vector<Record>& first,
                                                           const std::vector<Record>& second,
                                                           const std::string& success);

/// Median and 95 % quantile of the time that a stage took, of all records that have it.
struct StageTime {
  std::string stage;
  double median_s = 0.0;
  double p95_s = 0.0;
};
/// In the order in which stages first occur.
std::vector<StageTime> StageTimes(const std::vector<Record>& records);

}  // namespace rangegrasp::experiment
