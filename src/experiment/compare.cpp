#include "experiment/compare.h"

#include <map>
#include <utility>

#include "core/quantile.h"
#include "experiment/statistics.h"

namespace rangegrasp::experiment {

Comparison Compare(const std::vector<Record>& first, const std::vector<Record>& second,
                   const std::string& success) {
  std::map<std::pair<std::string, std::uint64_t>, const Record*> by_case;
  for (const Record& record : first) by_case[{record.which.id, record.which.seed}] = &record;
  Comparison comparison;
  for (const Record& b : second) {
    const auto found = by_case.find({b.which.id, b.which.seed});
    if (found == by_case.end()) continue;
    const std::string& outcome = found->second->result.outcome;
    const bool one = outcome == success;
    const bool two = b.result.outcome == success;
    ++comparison.pairs;
    comparison.both += one && two ? 1 : 0;
    comparison.only_first += one && !two ? 1 : 0;
    comparison.only_second += !one && two ? 1 : 0;
    comparison.same_outcome += outcome == b.result.outcome ? 1 : 0;
  }
  comparison.p_value = McNemarExact(comparison.only_first, comparison.only_second);
  return comparison;
}

std::vector<StageTime> StageTimes(const std::vector<Record>& records) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> by_stage;
  for (const Record& record : records) {
    for (const auto& [stage, seconds] : record.result.seconds) {
      if (!by_stage.contains(stage)) order.push_back(stage);
      by_stage[stage].push_back(seconds);
    }
  }
  std::vector<StageTime> times;
  for (const std::string& stage : order) {
    const auto& all = by_stage[stage];
    times.push_back(
        {stage, core::InterpolatedQuantileOf(all, 0.5), core::InterpolatedQuantileOf(all, 0.95)});
  }
  return times;
}

}  // namespace rangegrasp::experiment
