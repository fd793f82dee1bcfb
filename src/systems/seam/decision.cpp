#include "seam/decision.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "base/statistics.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Beyond this many standard deviations a bell adds less than 4e-6.
constexpr double kBellReach = 5.0;
// The same for a candidate's bell, where only the highest counts: less than 1.2 % is left beyond.
constexpr double kSpreadReach = 3.0;

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

// ---- the height of a step ----

// Length of a block; the fit uses the median of each block.
constexpr double kBlock_m = 0.5e-3;
// Blocks on each side of a place that show its step, and blocks next to it that are excluded. Frays
// are excluded, and half of a slant of 2 mm except for a part that the other blocks outweigh.
constexpr int kStepReach = 20;
constexpr int kStepGap = 1;
// Minimum number of blocks on a side: the four terms of the fit then rest on ten blocks.
constexpr int kMinBlocks = 5;
// Minimum number of averaged profiles: those in a period at 30 Hz (section 3.4).
constexpr std::size_t kMinProfiles = 3;

// Weights of the blocks on both sides of a place, without `gap` blocks on each side. The weighted
// sum is s of the least-squares fit of c0 + c1 t + c2 t^2 + s [t > 0].
std::vector<float> StepWeights(int left, int right, int gap) {
  Eigen::MatrixXd terms(left + right, 4);
  for (int i = 0; i < left + right; ++i) {
    const double t = (i < left ? i - left - gap : i - left + gap) + 0.5;
    terms.row(i) << 1.0, t, t * t, i < left ? 0.0 : 1.0;
  }
  const Eigen::RowVectorXf step =
      (terms.transpose() * terms).ldlt().solve(terms.transpose()).row(3).cast<float>();
  return {step.data(), step.data() + step.size()};
}

// Sorts the heights of each block, all blocks in parallel, by odd-even transposition (Knuth 1998):
// as many rounds as a block has columns are enough.
RANGEGRASP_VECTORISED void SortBlocks(float* heights, std::size_t columns, std::size_t blocks) {
  for (std::size_t round = 0; round < columns; ++round) {
    for (std::size_t k = round % 2; k + 1 < columns; k += 2) {
      float* low = heights + k * blocks;
      float* high = low + blocks;
      for (std::size_t b = 0; b < blocks; ++b) {
        const float less = std::min(low[b], high[b]);
        const float more = std::max(low[b], high[b]);
        low[b] = less;
        high[b] = more;
      }
    }
  }
}

// Median height of each block.
std::vector<float> MiddlesOf(std::span<const float> line, std::size_t columns) {
  const std::size_t blocks = line.size() / columns;
  std::vector<float> sorted(line.size());
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::size_t k = 0; k < columns; ++k) sorted[k * blocks + b] = line[b * columns + k];
  }
  SortBlocks(sorted.data(), columns, blocks);
  const float* middle = sorted.data() + columns / 2 * blocks;
  return {middle, middle + blocks};
}

int Whole(double ratio) { return static_cast<int>(std::lround(ratio)); }

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

std::optional<LinePrediction> PredictByLine(std::span<const TimedColumn> found, double time_s,
                                            const LinePredictionOptions& options) {
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
      if (std::abs(line.slope) > options.max_slope_columns_per_s) continue;
      const auto support = SupportOf(line, found, options.inlier_columns);
      if (support > best_support) {
        best_support = support;
        best = line;
      }
    }
  }
  std::vector<TimedColumn> inliers;
  for (const TimedColumn& p : found) {
    if (std::abs(p.column - best.At(p.time_s)) <= options.inlier_columns) inliers.push_back(p);
  }
  return LinePrediction{FitLine(inliers).At(time_s), static_cast<int>(inliers.size())};
}

std::vector<float> SumOfWeights(const std::array<DetectorResult, kDetectors>& results) {
  std::vector<float> sum = results[0].weight;
  for (std::size_t d = 1; d < results.size(); ++d) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += results[d].weight[i];
  }
  return sum;
}

std::vector<float> SpreadWeights(const std::vector<float>& weight, double sigma_columns) {
  const auto m = static_cast<int>(weight.size());
  const int reach = static_cast<int>(std::ceil(kSpreadReach * sigma_columns));
  std::vector<float> bell;
  for (int d = 0; d <= reach; ++d) bell.push_back(static_cast<float>(Bell(d, 0.0, sigma_columns)));
  std::vector<float> spread(weight.size(), 0.0F);
  for (int j = 0; j < m; ++j) {
    const float peak = weight[static_cast<std::size_t>(j)];
    if (!(peak > 0.0F)) continue;
    for (int i = std::max(0, j - reach); i <= std::min(m - 1, j + reach); ++i) {
      float& here = spread[static_cast<std::size_t>(i)];
      here = std::max(here, peak * bell[static_cast<std::size_t>(std::abs(i - j))]);
    }
  }
  return spread;
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

double StepHeight(std::span<const float> f, int column, const StepOptions& options) {
  const auto m = static_cast<int>(f.size());
  if (column < 0 || column >= m) return 0.0;
  const int begin = std::max(0, column - options.half_window);
  const int end = std::min(m, column + options.half_window + 1);
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (int i = begin; i < end; ++i) {
    const auto near = Within(f, i - options.median_half_width, i + options.median_half_width + 1);
    const float middle = base::UpperMedianOf(std::vector(near.begin(), near.end()));
    low = std::min(low, middle);
    high = std::max(high, middle);
  }
  return static_cast<double>(high) - static_cast<double>(low);
}

StepTest::StepTest(const LineGeometry& line, double period_s)
    : columns_(std::max(1, Whole(kBlock_m * line.columns_per_m))), period_s_(period_s) {}

void StepTest::Take(const PreparedProfile& profile) {
  times_.push_back(profile.time_s);
  if (times_.size() > kMinProfiles) times_.pop_front();
  const double oldest_s = std::min(times_.front(), profile.time_s - period_s_);
  while (!recent_.empty() && recent_.front().time_s < oldest_s) recent_.pop_front();
  if (!profile.Usable()) {
    if (recent_.empty()) mean_ = {};
    return;
  }
  Blocks blocks{profile.time_s, (profile.first_column + columns_ - 1) / columns_, {}};
  const int count = (profile.last_column + 1) / columns_ - blocks.first;
  if (count > 0) {
    const auto begin = profile.height_m.begin() + blocks.first * columns_;
    blocks.height_m =
        MiddlesOf({begin, begin + count * columns_}, static_cast<std::size_t>(columns_));
  }
  recent_.push_back(std::move(blocks));
  Average();
}

// Over the blocks of the last profile; the other profiles contribute only the blocks they have.
void StepTest::Average() {
  mean_ = recent_.back();
  std::vector<float> count(mean_.height_m.size(), 1.0F);
  for (std::size_t k = 0; k + 1 < recent_.size(); ++k) {
    const Blocks& other = recent_[k];
    const int shift = mean_.first - other.first;
    const int end = std::min(static_cast<int>(mean_.height_m.size()),
                             static_cast<int>(other.height_m.size()) - shift);
    for (int i = std::max(0, -shift); i < end; ++i) {
      mean_.height_m[static_cast<std::size_t>(i)] +=
          other.height_m[static_cast<std::size_t>(i + shift)];
      count[static_cast<std::size_t>(i)] += 1.0F;
    }
  }
  for (std::size_t i = 0; i < count.size(); ++i) mean_.height_m[i] /= count[i];
}

const StepTest::Kernel& StepTest::KernelOf(int left, int right, int gap) {
  const auto [place, is_new] = kernels_.try_emplace({left, right, gap});
  Kernel& kernel = place->second;
  if (!is_new) return kernel;
  kernel.weights = StepWeights(left, right, gap);
  double squares = 0.0;
  for (const float w : kernel.weights) squares += static_cast<double>(w) * static_cast<double>(w);
  kernel.certainty = 1.0 / std::sqrt(squares);
  return kernel;
}

std::optional<StepTest::Fit> StepTest::FitBefore(int block, int gap) {
  const int count = static_cast<int>(mean_.height_m.size());
  const int left = std::min(kStepReach, block) - gap;
  const int right = std::min(kStepReach, count - block) - gap;
  if (left < kMinBlocks || right < kMinBlocks) return std::nullopt;
  const Kernel& kernel = KernelOf(left, right, gap);
  const float* weight = kernel.weights.data();
  const float* low = mean_.height_m.data() + block - gap - left;
  const float* high = mean_.height_m.data() + block + gap;
  float height = 0.0F;
  for (int i = 0; i < left; ++i) height += weight[i] * low[i];
  for (int i = 0; i < right; ++i) height += weight[left + i] * high[i];
  return Fit{static_cast<double>(height), kernel.certainty};
}

std::optional<double> StepTest::HeightAt(double column) {
  const int block = Whole(column / columns_) - mean_.first;
  std::optional<double> highest;
  for (int near = block - 1; near <= block + 1; ++near) {
    const auto fit = FitBefore(near, kStepGap);
    if (fit && (!highest || fit->height_m > *highest)) highest = fit->height_m;
  }
  return highest;
}

// A step reduces the sum of squares by (height x certainty)^2. The parabola through the best block
// and its neighbors interpolates between blocks.
std::optional<double> StepTest::Locate(double column, double within_columns) {
  const auto score = [&](int block) {
    const auto fit = FitBefore(block, 0);
    return fit ? fit->height_m * fit->certainty : 0.0;
  };
  const int begin = Whole((column - within_columns) / columns_) - mean_.first;
  const int end = Whole((column + within_columns) / columns_) - mean_.first;
  int best = begin;
  double highest = 0.0;
  for (int block = begin; block <= end; ++block) {
    const double here = score(block);
    if (here <= highest) continue;
    highest = here;
    best = block;
  }
  if (highest <= 0.0) return std::nullopt;
  const double offset = SummitOffset(score(best - 1), highest, score(best + 1));
  return (best + mean_.first + offset) * columns_;
}

}  // namespace rangegrasp::seam
