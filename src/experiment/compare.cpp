#include "experiment/compare.h"

#include <map>
#include <utility>

#include "base/quantile.h"
#include "experiment/statistics.h"

namespace rangegrasp::experiment {

namespace {

// Positions of the cases that are in both.
std::vector<std::pair<std::size_t, std::size_t>> PairsOf(const std::vector<Record>& first,
                                                         const std::vector<Record>& second) {
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> by_case;
  for (std::size_t i = 0; i < first.size(); ++i) {
    by_case[{first[i].which.id, first[i].which.seed}] = i;
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < second.size(); ++i) {
    const auto found = by_case.find({second[i].which.id, second[i].which.seed});
    if (found != by_case.end()) pairs.emplace_back(found->second, i);
  }
  return pairs;
}

}  // namespace

Comparison Compare(const std::vector<Record>& first, const std::vector<Record>& second,
                   const std::string& success) {
  Comparison comparison;
  for (const auto& [a, b] : PairsOf(first, second)) {
    const std::string& outcome = first[a].result.outcome;
    const bool one = outcome == success;
    const bool two = second[b].result.outcome == success;
    ++comparison.pairs;
    comparison.both += one && two ? 1 : 0;
    comparison.only_first += one && !two ? 1 : 0;
    comparison.only_second += !one && two ? 1 : 0;
    comparison.same_outcome += outcome == second[b].result.outcome ? 1 : 0;
  }
  comparison.p_value = McNemarExact(comparison.only_first, comparison.only_second);
  return comparison;
}

std::vector<std::pair<std::size_t, std::size_t>> Differing(const std::vector<Record>& first,
                                                           const std::vector<Record>& second,
                                                           const std::string& success) {
  auto pairs = PairsOf(first, second);
  std::erase_if(pairs, [&](const auto& pair) {
    const bool one = first[pair.first].result.outcome == success;
    return one == (second[pair.second].result.outcome == success);
  });
  return pairs;
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
        {stage, base::InterpolatedQuantileOf(all, 0.5), base::InterpolatedQuantileOf(all, 0.95)});
  }
  return times;
}

}  // namespace rangegrasp::experiment
