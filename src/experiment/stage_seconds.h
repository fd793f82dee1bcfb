#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::experiment {

/// Adds to a stage's time; a stage that is not there yet comes last.
inline void AddSeconds(const std::string& stage, double seconds,
                       std::vector<std::pair<std::string, double>>& sums) {
  const auto found =
      std::find_if(sums.begin(), sums.end(), [&](const auto& sum) { return sum.first == stage; });
  if (found == sums.end()) {
    sums.emplace_back(stage, seconds);
  } else {
    found->second += seconds;
  }
}

}  // namespace rangegrasp::experiment
