#include "seam/step_test.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "seam/internal/summit.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Blocks on a side, at least: the four terms of the fit rest on ten then.
constexpr int kMinBlocks = 5;
// Profiles that are averaged, at least: as many as a period has at 30 Hz (section 3.4).
constexpr std::size_t kMinProfiles = 3;

// Weights of the blocks on both sides of a place, `gap` on each left out, whose sum is s of the
// least-squares fit of c0 + c1 t + c2 t^2 + s [t > 0].
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

// Sorts the heights of each block, all blocks side by side: by exchanges of neighbors, of which as
// many rounds as a block has columns suffice (odd-even transposition; Knuth 1998).
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

// The middle one of each block's heights; `sorted` is room to work in.
std::vector<float> MiddlesOf(std::span<const float> line, std::size_t columns,
                             std::vector<float>& sorted) {
  const std::size_t blocks = line.size() / columns;
  sorted.resize(line.size());
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::size_t k = 0; k < columns; ++k) sorted[k * blocks + b] = line[b * columns + k];
  }
  SortBlocks(sorted.data(), columns, blocks);
  const float* middle = sorted.data() + columns / 2 * blocks;
  return {middle, middle + blocks};
}

int Whole(double ratio) { return static_cast<int>(std::lround(ratio)); }

}  // namespace

StepTest::StepTest(const LineGeometry& line, const StepTestOptions& options)
    : columns_(std::max(1, Whole(options.block_m * line.columns_per_m))),
      reach_(Whole(options.reach_m / options.block_m)),
      gap_(Whole(options.gap_m / options.block_m)),
      period_s_(options.period_s) {}

void StepTest::Take(const PreparedProfile& profile) {
  while (recent_.size() >= kMinProfiles && recent_.front().time_s < profile.time_s - period_s_) {
    recent_.pop_front();
  }
  if (!profile.Usable()) return;
  Blocks blocks{profile.time_s, (profile.first_column + columns_ - 1) / columns_, {}};
  const int count = (profile.last_column + 1) / columns_ - blocks.first;
  if (count > 0) {
    const auto begin = profile.height_m.begin() + blocks.first * columns_;
    blocks.height_m =
        MiddlesOf({begin, begin + count * columns_}, static_cast<std::size_t>(columns_), heights_);
  }
  recent_.push_back(std::move(blocks));
  Average();
}

// Over the blocks of the last profile: the others' only where they have them, too.
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
  const int left = std::min(reach_, block) - gap;
  const int right = std::min(reach_, count - block) - gap;
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
    const auto fit = FitBefore(near, gap_);
    if (fit && (!highest || fit->height_m > *highest)) highest = fit->height_m;
  }
  return highest;
}

// A step makes the sum of squares smaller by (height x certainty)^2. Between blocks the parabola
// through the best place and its neighbors tells.
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
  const double offset = internal::SummitOffset(score(best - 1), highest, score(best + 1));
  return (best + mean_.first + offset) * columns_;
}

}  // namespace rangegrasp::seam
