#include "stereo/sensing/internal/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace rangegrasp::sensing::internal {
namespace {

constexpr int kShareBits = 8;
constexpr int kShare = 1 << kShareBits;  // steps between two drawn pixels
constexpr int kOneBits = 6;
static_assert(1 << kOneBits == LensMap::kOne);
constexpr int kQuantileBits = 12;  // beyond 3.5 sigma there is nothing; a word holds five draws
constexpr int kDrawsPerWord = 64 / kQuantileBits;

double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// By Newton's method, from a start that is below the solution for p > 1/2 (the CDF is concave).
double NormalQuantile(double p) {
  if (p < 0.5) return -NormalQuantile(1.0 - p);
  double x = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
    const double step = (p - NormalCdf(x)) / density;
    x += step;
    if (std::abs(step) < 1e-12) break;
  }
  return x;
}

}  // namespace

LensMap::LensMap(const stereo::Camera& camera) : width_(camera.width) {
  const auto pixels =
      static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  std::vector<Eigen::Vector2f> seen(pixels);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const Eigen::Vector2d place = camera.fx * stereo::RayOf(camera, {x, y}).head<2>();
      if (!place.allFinite()) {
        throw std::invalid_argument("stereo camera: k1, k2, p1, p2 fold the picture over itself");
      }
      seen[i] = place.cast<float>();
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
  }
  // One pixel round what is seen, so that each place has four neighbors.
  drawn_center_ = (1.0 - low.array()).ceil();
  const Eigen::Vector2d size = (high + drawn_center_).array().ceil() + 2.0;
  drawn_width_ = static_cast<int>(size.x());
  drawn_height_ = static_cast<int>(size.y());
  places_.reserve(pixels);
  for (const Eigen::Vector2f& place : seen) {
    const Eigen::Array2d at = place.cast<double>() + drawn_center_;
    const Eigen::Array2d whole = at.floor();
    const Eigen::Array2d share = ((at - whole) * kShare).floor();
    places_.push_back(
        {3 * (static_cast<std::uint32_t>(whole.y()) * static_cast<std::uint32_t>(drawn_width_) +
              static_cast<std::uint32_t>(whole.x())),
         static_cast<std::uint16_t>(share.x()), static_cast<std::uint16_t>(share.y())});
  }
}

void LensMap::SampleRow(const image::Image& drawn, int row, std::vector<std::int32_t>& out) const {
  constexpr int kDown = 2 * kShareBits - kOneBits;
  const std::size_t stride = 3 * static_cast<std::size_t>(drawn_width_);
  out.resize(3 * static_cast<std::size_t>(width_));
  const Place* place =
      places_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
  for (std::size_t i = 0; i < out.size(); i += 3, ++place) {
    const std::uint8_t* upper = drawn.rgb.data() + place->pixel;
    const std::uint8_t* lower = upper + stride;
    const int right = place->right, down = place->down;
    for (int c = 0; c < 3; ++c) {
      const int above = upper[c] * (kShare - right) + upper[c + 3] * right;
      const int below = lower[c] * (kShare - right) + lower[c + 3] * right;
      out[i + static_cast<std::size_t>(c)] = (above * (kShare - down) + below * down) >> kDown;
    }
  }
}

void Blur(image::Image& picture, double sigma_px) {
  // Weights (s, 1 - 2 s, s) have the variance 2 s.
  const int side = static_cast<int>(std::lround(kShare * 0.5 * sigma_px * sigma_px));
  if (side == 0) return;
  const int middle = kShare - 2 * side;
  const std::size_t stride = 3 * static_cast<std::size_t>(picture.width);
  std::vector<std::uint8_t> across(picture.rgb.size());
  const auto smooth = [&](const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to,
                          std::size_t step) {
    std::copy_n(from.begin(), step, to.begin());
    std::copy(from.end() - static_cast<std::ptrdiff_t>(step), from.end(),
              to.end() - static_cast<std::ptrdiff_t>(step));
    for (std::size_t i = step; i + step < from.size(); ++i) {
      to[i] = static_cast<std::uint8_t>(
          (side * (from[i - step] + from[i + step]) + middle * from[i] + kShare / 2) >> kShareBits);
    }
  };
  // The ends of rows mix with those of their neighbors: they lie outside of what the lens sees.
  smooth(picture.rgb, across, 3);
  smooth(across, picture.rgb, stride);
}

PixelNoise::PixelNoise(double sigma) {
  constexpr int kCount = 1 << kQuantileBits;
  for (int i = 0; i < kCount; ++i) {
    quantiles_.push_back(
        static_cast<std::int32_t>(std::lround(sigma * NormalQuantile((i + 0.5) / kCount))));
  }
}

void PixelNoise::AddTo(std::vector<std::int32_t>& values, base::Rng& rng) const {
  constexpr std::uint64_t kMask = (1 << kQuantileBits) - 1;
  for (std::size_t i = 0; i < values.size();) {
    std::uint64_t bits = rng.Next();
    for (int draw = 0; draw < kDrawsPerWord && i < values.size(); ++draw, ++i) {
      values[i] += quantiles_[bits & kMask];
      bits >>= kQuantileBits;
    }
  }
}

}  // namespace rangegrasp::sensing::internal
