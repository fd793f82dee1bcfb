#include "seam/detectors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "seam/internal/vectorised.h"
#include "seam/profile.h"

namespace rangegrasp::seam {
namespace {

// With fewer columns an edge cannot be distinguished from an end: eq. 3.5 uses three on each side.
constexpr std::size_t kMinEdgeColumns = 8;
// k of eq. 3.5, n of eq. 3.6 to 3.8 [columns], and number of candidates (eq. 3.9; section 3.3.2).
constexpr int kStepColumns = 3;
constexpr int kVotingHalf = 75;
constexpr int kCandidates = 30;
// Longest kernel as a share of the profile (section 3.3.3).
constexpr double kKernel = 0.1;

DetectorResult Nothing(std::size_t m) { return {std::nullopt, std::vector<float>(m, 0.0F)}; }

// Uses four parallel sums: faster than one, and always in the same order.
double SumOf(std::span<const float> f) {
  constexpr std::size_t kLanes = 4;
  double sum[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= f.size(); i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      sum[lane] += static_cast<double>(f[i + lane]);
    }
  }
  for (; i < f.size(); ++i) sum[0] += static_cast<double>(f[i]);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// Sum over n values x, whose sum is `sum`, of (x - level)^2 - x^2.
double Shifted(double n, double sum, double level) { return level * (n * level - 2.0 * sum); }

// S(j) for j = 1 .. m-1 (eq. 3.2); S(0) is left at 0.
std::vector<double> SquaredDistances(std::span<const float> f) {
  const std::size_t m = f.size();
  const double mean = SumOf(f) / static_cast<double>(m);
  std::vector<double> sum_left(m);  // sum of f(i) - mean, i < j
  double total = 0.0;
  double squares = 0.0;
  for (std::size_t j = 0; j < m; ++j) {
    sum_left[j] = total;
    // Relative to the mean, so that sums of squares keep their precision.
    const double z = static_cast<double>(f[j]) - mean;
    total += z;
    squares += z * z;
  }
  const auto [min, max] = std::ranges::minmax(f);
  const double low = static_cast<double>(min) - mean;
  const double high = static_cast<double>(max) - mean;
  std::vector<double> S(m, 0.0);
  for (std::size_t j = 1; j < m; ++j) {
    // Via 32 bits, which vector instructions can convert.
    const auto n_left = static_cast<double>(static_cast<std::int32_t>(j));
    const auto n_right = static_cast<double>(static_cast<std::int32_t>(m - j));
    const double left = sum_left[j];
    S[j] = squares + Shifted(n_left, left, low) + Shifted(n_right, total - left, high);
  }
  return S;
}

// The last column of the first run of maximal values; nullopt if none is above 0.
std::optional<int> EndOfMaximum(const std::vector<float>& values) {
  auto at = std::max_element(values.begin(), values.end());
  if (at == values.end() || !(*at > 0.0F)) return std::nullopt;
  while (at + 1 != values.end() && *(at + 1) == *at) ++at;
  return static_cast<int>(at - values.begin());
}

void DivideByMaximum(std::vector<float>& values) {
  const float max = *std::max_element(values.begin(), values.end());
  if (!(max > 0.0F)) return;
  for (float& value : values) value /= max;
}

// Eq. 3.5: the step's height from a few columns on either side.
double CandidateWeight(std::span<const float> f, int j) {
  const auto m = static_cast<int>(f.size());
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (int k = 1; k <= kStepColumns; ++k) {
    high = std::max(high, f[static_cast<std::size_t>(std::min(m - 1, j + k))]);
    low = std::min(low, f[static_cast<std::size_t>(std::max(0, j - k))]);
  }
  return std::abs(static_cast<double>(high) - static_cast<double>(low));
}

// Eq. 3.6 to 3.8 for the candidate j.
double VotingSum(std::span<const float> f, int j) {
  const int begin = std::max(0, j - kVotingHalf);
  const int end = std::min(static_cast<int>(f.size()), j + kVotingHalf + 1);
  const double average = SumOf(Within(f, begin, end)) / (end - begin);
  const float* z = f.data();
  int votes = 0;
  for (int i = begin; i < j; ++i) votes += static_cast<double>(z[i]) < average ? j - i : 0;
  for (int i = j + 1; i < end; ++i) votes += static_cast<double>(z[i]) > average ? i - j : 0;
  return CandidateWeight(f, j) * votes;
}

// Number of columns whose sums stay in registers in the loop over k.
constexpr std::size_t kProfileTile = 32;

// Eq. 3.12. Every sum is accumulated in the order of k, for any vector width.
RANGEGRASP_VECTORISED void SumGradients(const float* f, std::size_t n, std::size_t tiles,
                                        float* G) {
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    const float* center = f + tile * kProfileTile;
    float sum[kProfileTile] = {};
    for (std::size_t k = 1; k <= n; ++k) {
      const float* right = center + k;
      const float* left = center - k;
      for (std::size_t i = 0; i < kProfileTile; ++i) sum[i] += std::abs(right[i] - left[i]);
    }
    std::copy_n(sum, kProfileTile, G + tile * kProfileTile);
  }
}

}  // namespace

DetectorResult FitEdgeModel(std::span<const float> f) {
  const std::size_t m = f.size();
  const auto is_first = [&](float z) { return z == f[0]; };
  if (m < kMinEdgeColumns || std::ranges::all_of(f, is_first)) return Nothing(m);  // flat
  const std::vector<double> S = SquaredDistances(f);
  const auto best = std::min_element(S.begin() + 1, S.end());
  const double max = *std::max_element(S.begin() + 1, S.end());
  DetectorResult result{static_cast<int>(best - S.begin()), std::vector<float>(m, 0.0F)};
  if (!(max > 0.0)) return result;
  const double scale = 1.0 / max;
  for (std::size_t j = 1; j < m; ++j) result.weight[j] = static_cast<float>(1.0 - S[j] * scale);
  return result;
}

std::vector<int> EdgeCandidates(std::span<const float> f, int candidates) {
  std::vector<std::pair<float, int>> steps;  // -|f(j+1) - f(j)| and j+1: the first are the best
  for (std::size_t j = 1; j < f.size(); ++j) {
    if (f[j] != f[j - 1]) steps.emplace_back(-std::abs(f[j] - f[j - 1]), static_cast<int>(j));
  }
  const auto end = steps.begin() + std::min<std::ptrdiff_t>(candidates, std::ssize(steps));
  std::partial_sort(steps.begin(), end, steps.end());
  std::vector<int> columns;
  for (auto step = steps.begin(); step != end; ++step) columns.push_back(step->second);
  return columns;
}

DetectorResult VoteLocally(std::span<const float> f) {
  const std::size_t m = f.size();
  DetectorResult result = Nothing(m);
  if (m < kMinEdgeColumns) return result;
  double best = 0.0;
  for (const int j : EdgeCandidates(f, kCandidates)) {
    const double S = VotingSum(f, j);
    result.weight[static_cast<std::size_t>(j)] = static_cast<float>(S);
    if (S > best || (S == best && result.column && j < *result.column)) {
      best = S;
      result.column = j;
    }
  }
  DivideByMaximum(result.weight);
  return result;
}

DetectorResult AccumulateGradients(std::span<const float> f) {
  const std::size_t m = f.size();
  if (m < kMinEdgeColumns) return Nothing(m);
  const auto n =
      std::max<std::size_t>(1, static_cast<std::size_t>(kKernel * static_cast<double>(m)));
  const std::size_t tiles = (m + kProfileTile - 1) / kProfileTile;
  std::vector<float> padded(tiles * kProfileTile + 2 * n, f[m - 1]);
  std::fill_n(padded.begin(), n, f[0]);
  std::copy(f.begin(), f.end(), padded.begin() + static_cast<std::ptrdiff_t>(n));
  std::vector<float> G(tiles * kProfileTile);
  SumGradients(padded.data() + n, n, tiles, G.data());
  G.resize(m);
  // An ideal step is as strong at the last low column as at the first high one: take the latter.
  DetectorResult result{EndOfMaximum(G), std::move(G)};
  DivideByMaximum(result.weight);
  return result;
}

std::array<DetectorResult, kDetectors> DetectEdges(std::span<const float> f) {
  return {FitEdgeModel(f), VoteLocally(f), AccumulateGradients(f)};
}

}  // namespace rangegrasp::seam
