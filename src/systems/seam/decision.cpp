#include "seam/decision.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "base/statistics.h"
#include "seam/profile.h"

namespace rangegrasp::seam {
namespace {

// Beyond this many standard deviations a bell adds less than 4e-6.
constexpr double kBellReach = 5.0;

// Maximum number of points whose pairs are tried as lines.
constexpr std::size_t kTried = 16;

// At most `count` evenly spread points, including the first and the last.
std::vector<TimedColumn> SpreadOver(std::span<const TimedColumn> points, std::size_t count) {
  if (points.size() <= count) return {points.begin(), points.end()};
  std::vector<TimedColumn> some;
  for (std::size_t i = 0; i < count; ++i) {
    some.push_back(points[i * (points.size() - 1) / (count - 1)]);
  }
  return some;
}

// Number of inliers of a line, and minus the sum of their squared errors: a greater pair is better.
std::pair<int, double> SupportOf(const TimedLine& line, std::span<const TimedColumn> points,
                                 double tolerance) {
  std::pair support(0, 0.0);
  for (const TimedColumn& p : points) {
    const double error = p.column - line.At(p.time_s);
    if (std::abs(error) > tolerance) continue;
    ++support.first;
    support.second -= error * error;
  }
  return support;
}

// Half windows [columns] of the step height (section 3.5.3) and of the median before it: a median
// as wide as the step's window flattens slanted edges.
constexpr int kStepHalf = 10;
constexpr int kStepMedianHalf = 6;

}  // namespace

std::optional<double> VoteTwoOfThree(const std::array<std::optional<int>, kDetectors>& columns,
                                     double tolerance_columns) {
  std::optional<double> mean;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < columns.size(); ++a) {
    for (std::size_t b = a + 1; b < columns.size(); ++b) {
      if (!columns[a] || !columns[b]) continue;
      const double distance = std::abs(*columns[a] - *columns[b]);
      if (distance > tolerance_columns || distance >= nearest) continue;
      nearest = distance;
      mean = 0.5 * (*columns[a] + *columns[b]);
    }
  }
  return mean;
}

TimedLine FitLine(std::span<const TimedColumn> positions) {
  double time = 0.0;
  double column = 0.0;
  for (const TimedColumn& p : positions) {
    time += p.time_s;
    column += p.column;
  }
  const auto n = static_cast<double>(positions.size());
  time /= n;
  column /= n;
  double tt = 0.0;
  double tc = 0.0;
  for (const TimedColumn& p : positions) {
    tt += (p.time_s - time) * (p.time_s - time);
    tc += (p.time_s - time) * (p.column - column);
  }
  return {time, column, tt > 0.0 ? tc / tt : 0.0};
}

std::optional<double> PredictByLine(std::span<const TimedColumn> found, double time_s,
                                    double inlier_columns) {
  if (found.empty()) return std::nullopt;
  TimedLine best{found.back().time_s, found.back().column, 0.0};
  std::pair best_support(0, 0.0);
  const std::vector<TimedColumn> tried = SpreadOver(found, kTried);
  for (std::size_t a = 0; a < tried.size(); ++a) {
    for (std::size_t b = a + 1; b < tried.size(); ++b) {
      const double dt = tried[b].time_s - tried[a].time_s;
      if (dt == 0.0) continue;
      const TimedLine line{tried[a].time_s, tried[a].column,
                           (tried[b].column - tried[a].column) / dt};
      const auto support = SupportOf(line, found, inlier_columns);
      if (support > best_support) {
        best_support = support;
        best = line;
      }
    }
  }
  std::vector<TimedColumn> inliers;
  for (const TimedColumn& p : found) {
    if (std::abs(p.column - best.At(p.time_s)) <= inlier_columns) inliers.push_back(p);
  }
  return FitLine(inliers).At(time_s);
}

std::vector<float> SumOfWeights(const std::array<DetectorResult, kDetectors>& results) {
  std::vector<float> sum = results[0].weight;
  for (std::size_t d = 1; d < results.size(); ++d) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += results[d].weight[i];
  }
  return sum;
}

double Bell(double x, double x1, double sigma) {
  return std::exp(-(x - x1) * (x - x1) / (2.0 * sigma * sigma));
}

void WeightByHistory(std::span<float> weight, std::span<const double> history,
                     double sigma_columns) {
  if (history.empty()) return;
  const auto m = static_cast<int>(weight.size());
  const auto n = static_cast<double>(history.size());
  std::vector<double> nearness(weight.size(), 0.0);
  for (std::size_t t = 0; t < history.size(); ++t) {
    const double reach = kBellReach * sigma_columns;
    const int begin = std::max(0, static_cast<int>(std::ceil(history[t] - reach)));
    const int end = std::min(m - 1, static_cast<int>(std::floor(history[t] + reach)));
    // exp(-(d+1)^2/2s^2) follows from exp(-d^2/2s^2) by two products: one exp per bell instead of
    // one per column.
    const double s2 = sigma_columns * sigma_columns;
    double bell = Bell(begin, history[t], sigma_columns);
    double factor = std::exp(-(2.0 * (begin - history[t]) + 1.0) / (2.0 * s2));
    const double ratio = std::exp(-1.0 / s2);
    for (int i = begin; i <= end; ++i) {
      nearness[static_cast<std::size_t>(i)] += static_cast<double>(t + 1) * bell;
      bell *= factor;
      factor *= ratio;
    }
  }
  for (std::size_t i = 0; i < weight.size(); ++i) {
    weight[i] *= static_cast<float>(1.0 + nearness[i] / (n * (n + 1.0)));
  }
}

double StepHeight(std::span<const float> f, int column) {
  const auto m = static_cast<int>(f.size());
  if (column < 0 || column >= m) return 0.0;
  const int begin = std::max(0, column - kStepHalf);
  const int end = std::min(m, column + kStepHalf + 1);
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (int i = begin; i < end; ++i) {
    const auto near = Within(f, i - kStepMedianHalf, i + kStepMedianHalf + 1);
    const float middle = base::UpperMedianOf(std::vector(near.begin(), near.end()));
    low = std::min(low, middle);
    high = std::max(high, middle);
  }
  return static_cast<double>(high) - static_cast<double>(low);
}

}  // namespace rangegrasp::seam
