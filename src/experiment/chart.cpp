#include "experiment/chart.h"

#include <fmt/format.h>

#include "experiment/statistics.h"

namespace rangegrasp::experiment {

Chart::Value PercentOf(const Count& count) {
  if (count.n == 0) return {};
  const auto [low, high] = WilsonInterval(count.k, count.n);
  return {100.0 * count.k / count.n, std::pair(100.0 * low, 100.0 * high),
          fmt::format("{} of {}", count.k, count.n)};
}

}  // namespace rangegrasp::experiment
