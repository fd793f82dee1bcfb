#include "seam/detectors.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace rangegrasp::seam {
namespace {

// Fewer columns hold no edge that could be told from an end.
constexpr std::size_t kFewestColumns = 8;

DetectorResult Nothing(std::size_t m) { return {std::nullopt, std::vector<float>(m, 0.0F)}; }

double MeanOf(std::span<const float> f) {
  return std::accumulate(f.begin(), f.end(), 0.0) / static_cast<double>(f.size());
}

bool IsFlat(std::span<const float> f) {
  return std::all_of(f.begin(), f.end(), [&](float z) { return z == f[0]; });
}

// Running figures of the columns left of j, and from j on.
struct StepModel {
  std::vector<double> max_right;  // of f(i), i >= j
  double sum = 0.0;
  double sum_of_squares = 0.0;
  double mean;

  explicit StepModel(std::span<const float> f) : max_right(f.size()), mean(MeanOf(f)) {
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t j = f.size(); j-- > 0;) {
      const double z = Centred(f[j]);
      largest = std::max(largest, z);
      max_right[j] = largest;
      sum += z;
      sum_of_squares += z * z;
    }
  }
  // About the mean, so that sums of squares keep their digits.
  double Centred(float z) const { return static_cast<double>(z) - mean; }
};

// S(j) for j = 1 .. m-1 (eq. 3.2); S(0) is left at 0.
std::vector<double> SquaredDistances(std::span<const float> f, ModelLevels levels) {
  const StepModel model(f);
  const std::size_t m = f.size();
  std::vector<double> S(m, 0.0);
  double left = 0.0;
  double left_squares = 0.0;
  double min_left = std::numeric_limits<double>::infinity();
  for (std::size_t j = 1; j < m; ++j) {
    const double z = model.Centred(f[j - 1]);
    left += z;
    left_squares += z * z;
    min_left = std::min(min_left, z);
    const auto n_left = static_cast<double>(j);
    const auto n_right = static_cast<double>(m - j);
    const double right = model.sum - left;
    const double right_squares = model.sum_of_squares - left_squares;
    const bool means = levels == ModelLevels::kMeans;
    const double low = means ? left / n_left : min_left;
    const double high = means ? right / n_right : model.max_right[j];
    S[j] = left_squares - 2.0 * low * left + n_left * low * low + right_squares -
           2.0 * high * right + n_right * high * high;
  }
  return S;
}

// The largest value's column, the last one of equal ones; nullopt if nothing is above 0.
std::optional<int> LastLargest(const std::vector<float>& values) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] >= values[best]) best = i;
  }
  if (values.empty() || !(values[best] > 0.0F)) return std::nullopt;
  return static_cast<int>(best);
}

void DivideByLargest(std::vector<float>& values) {
  const float largest = *std::max_element(values.begin(), values.end());
  if (!(largest > 0.0F)) return;
  for (float& value : values) value /= largest;
}

// Eq. 3.5: the step's height from three columns on either side.
double CandidateWeight(std::span<const float> f, int j) {
  const auto m = static_cast<int>(f.size());
  float high = -std::numeric_limits<float>::infinity();
  float low = std::numeric_limits<float>::infinity();
  for (int k = 1; k <= 3; ++k) {
    high = std::max(high, f[static_cast<std::size_t>(std::min(m - 1, j + k))]);
    low = std::min(low, f[static_cast<std::size_t>(std::max(0, j - k))]);
  }
  return std::abs(static_cast<double>(high) - static_cast<double>(low));
}

// Eq. 3.6 to 3.8 for the candidate j.
double VotingSum(std::span<const float> f, int j, int n) {
  const int begin = std::max(0, j - n);
  const int end = std::min(static_cast<int>(f.size()), j + n + 1);
  const float* z = f.data();
  double sum = 0.0;
  for (int i = begin; i < end; ++i) sum += static_cast<double>(z[i]);
  const auto average = static_cast<float>(sum / (end - begin));
  int votes = 0;
  for (int i = begin; i < j; ++i) votes += z[i] < average ? j - i : 0;
  for (int i = j + 1; i < end; ++i) votes += z[i] > average ? i - j : 0;
  return CandidateWeight(f, j) * votes;
}

// Columns whose sums stay in registers while k runs.
constexpr std::size_t kTile = 32;

// Eq. 3.12. Every sum is added up in the order of k, whatever the width of the vectors.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
__attribute__((target_clones("avx2", "default")))
#endif
void SumGradients(const float* f, std::size_t n, std::size_t tiles, float* G) {
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    const float* centre = f + tile * kTile;
    float sum[kTile] = {};
    for (std::size_t k = 1; k <= n; ++k) {
      const float* right = centre + k;
      const float* left = centre - k;
      for (std::size_t i = 0; i < kTile; ++i) sum[i] += std::abs(right[i] - left[i]);
    }
    std::copy_n(sum, kTile, G + tile * kTile);
  }
}

}  // namespace

const char* Name(Detector detector) {
  switch (detector) {
    case Detector::kModelFitting:
      return "Model-Fitting";
    case Detector::kLocalWeightedVoting:
      return "Local Weighted-Voting";
    case Detector::kGradientAccumulation:
      return "Gradient-Accumulation";
  }
  return "?";
}

DetectorResult FitEdgeModel(std::span<const float> f, const ModelFittingOptions& options) {
  const std::size_t m = f.size();
  if (m < kFewestColumns || IsFlat(f)) return Nothing(m);
  const std::vector<double> S = SquaredDistances(f, options.levels);
  const auto best = std::min_element(S.begin() + 1, S.end());
  const double largest = *std::max_element(S.begin() + 1, S.end());
  DetectorResult result{static_cast<int>(best - S.begin()), std::vector<float>(m, 0.0F)};
  if (!(largest > 0.0)) return result;
  for (std::size_t j = 1; j < m; ++j) result.weight[j] = static_cast<float>(1.0 - S[j] / largest);
  return result;
}

std::vector<int> EdgeCandidates(std::span<const float> f, int candidates) {
  if (candidates < 1)
    throw std::invalid_argument("local weighted-voting: candidates must be at least 1");
  if (f.size() < 2) return {};
  // A difference is not negative, so its bits order as it does; below them the column, so that
  // the smaller one wins among equals.
  std::vector<std::uint64_t> keys(f.size() - 1);
  for (std::size_t j = 0; j + 1 < f.size(); ++j) {
    const auto bits = std::bit_cast<std::uint32_t>(std::abs(f[j + 1] - f[j]));
    keys[j] = (static_cast<std::uint64_t>(bits) << 32U) |
              (0xffffffffU - static_cast<std::uint32_t>(j + 1));
  }
  const auto count = std::min(keys.size(), static_cast<std::size_t>(candidates));
  const auto middle = keys.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(keys.begin(), middle - 1, keys.end(), std::greater<>());
  std::sort(keys.begin(), middle, std::greater<>());
  std::vector<int> columns;
  for (auto key = keys.begin(); key != middle; ++key) {
    columns.push_back(static_cast<int>(0xffffffffU - static_cast<std::uint32_t>(*key)));
  }
  return columns;
}

DetectorResult VoteLocally(std::span<const float> f, const LocalWeightedVotingOptions& options) {
  if (options.half_window < 1) {
    throw std::invalid_argument("local weighted-voting: half_window must be at least 1");
  }
  const std::size_t m = f.size();
  if (m < kFewestColumns) return Nothing(m);
  DetectorResult result = Nothing(m);
  double best = 0.0;
  for (const int j : EdgeCandidates(f, options.candidates)) {
    const double S = VotingSum(f, j, options.half_window);
    result.weight[static_cast<std::size_t>(j)] = static_cast<float>(S);
    if (S > best || (S == best && result.column && j < *result.column)) {
      best = S;
      result.column = j;
    }
  }
  if (!(best > 0.0)) return Nothing(m);
  DivideByLargest(result.weight);
  return result;
}

DetectorResult AccumulateGradients(std::span<const float> f,
                                   const GradientAccumulationOptions& options) {
  if (!(options.kernel > 0.0 && options.kernel <= 0.5)) {
    throw std::invalid_argument("gradient accumulation: kernel must be above 0 and at most 0.5");
  }
  const std::size_t m = f.size();
  if (m < kFewestColumns) return Nothing(m);
  const auto n =
      std::max<std::size_t>(1, static_cast<std::size_t>(options.kernel * static_cast<double>(m)));
  const std::size_t tiles = (m + kTile - 1) / kTile;
  std::vector<float> padded(tiles * kTile + 2 * n, f[m - 1]);
  std::fill_n(padded.begin(), n, f[0]);
  std::copy(f.begin(), f.end(), padded.begin() + static_cast<std::ptrdiff_t>(n));
  std::vector<float> G(tiles * kTile);
  SumGradients(padded.data() + n, n, tiles, G.data());
  G.resize(m);
  // An ideal step is as strong at the last low column as at the first high one: take the latter.
  DetectorResult result{LastLargest(G), std::move(G)};
  DivideByLargest(result.weight);
  return result;
}

std::array<DetectorResult, kDetectors> DetectEdges(std::span<const float> f,
                                                   const DetectorOptions& options) {
  return {FitEdgeModel(f, options.model_fitting), VoteLocally(f, options.local_weighted_voting),
          AccumulateGradients(f, options.gradient_accumulation)};
}

}  // namespace rangegrasp::seam
