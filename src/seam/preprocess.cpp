#include "seam/preprocess.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace rangegrasp::seam {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

void Check(const FilterOptions& options) {
  if (options.half_width_columns < 1 || !(options.half_height_m > 0.0) ||
      options.min_neighbours < 0) {
    throw std::invalid_argument(
        "geometric filter: half_width_columns must be at least 1, half_height_m above 0, "
        "min_neighbours at least 0");
  }
}

// Column i of m mapped to [-1, 1].
double Mapped(std::size_t i, std::size_t m) {
  return m < 2 ? 0.0 : 2.0 * static_cast<double>(i) / static_cast<double>(m - 1) - 1.0;
}

}  // namespace

std::vector<float> FilterGeometric(std::span<const float> height_m, const FilterOptions& options) {
  Check(options);
  const std::size_t m = height_m.size();
  std::vector<int> neighbours(m, 0);
  const auto reach = std::min(static_cast<std::size_t>(options.half_width_columns), m);
  const auto half_height = static_cast<float>(options.half_height_m);
  const float* z = height_m.data();
  int* count = neighbours.data();
  // Offsets outside, columns inside: the inner loops vectorise. Comparisons with NaN are false.
  for (std::size_t d = 1; d < reach + 1 && d < m; ++d) {
    for (std::size_t i = 0; i + d < m; ++i) {
      count[i] += std::abs(z[i + d] - z[i]) <= half_height ? 1 : 0;
    }
    for (std::size_t i = d; i < m; ++i) {
      count[i] += std::abs(z[i - d] - z[i]) <= half_height ? 1 : 0;
    }
  }
  std::vector<float> kept(m);
  for (std::size_t i = 0; i < m; ++i)
    kept[i] = count[i] >= options.min_neighbours ? z[i] : kMissing;
  return kept;
}

std::array<double, 3> FitQuadratic(std::span<const float> height_m) {
  const std::size_t m = height_m.size();
  std::array<double, 5> power{};   // sums of u^0 .. u^4
  std::array<double, 3> moment{};  // sums of z u^0 .. z u^2
  for (std::size_t i = 0; i < m; ++i) {
    const double z = static_cast<double>(height_m[i]);
    if (!std::isfinite(z)) continue;
    const double u = Mapped(i, m);
    const double u2 = u * u;
    power[0] += 1.0;
    power[1] += u;
    power[2] += u2;
    power[3] += u2 * u;
    power[4] += u2 * u2;
    moment[0] += z;
    moment[1] += z * u;
    moment[2] += z * u2;
  }
  std::array<double, 3> c{};
  const int terms = std::min(3, static_cast<int>(power[0]));
  if (terms == 0) return c;
  Eigen::MatrixXd normal(terms, terms);
  Eigen::VectorXd right(terms);
  for (int row = 0; row < terms; ++row) {
    for (int col = 0; col < terms; ++col) {
      normal(row, col) = power[static_cast<std::size_t>(row + col)];
    }
    right(row) = moment[static_cast<std::size_t>(row)];
  }
  const Eigen::VectorXd solved = normal.ldlt().solve(right);
  for (int k = 0; k < terms; ++k) c[static_cast<std::size_t>(k)] = solved(k);
  return c;
}

void FillHoles(std::span<float> height_m) {
  const std::size_t m = height_m.size();
  std::size_t begin = 0;
  while (begin < m) {
    if (std::isfinite(height_m[begin])) {
      ++begin;
      continue;
    }
    std::size_t end = begin;
    while (end < m && !std::isfinite(height_m[end])) ++end;
    if (begin == 0 && end == m) return;
    const float left = begin > 0 ? height_m[begin - 1] : height_m[end];
    const float right = end < m ? height_m[end] : left;
    const std::size_t middle = begin + (end - begin) / 2;
    for (std::size_t i = begin; i < end; ++i) height_m[i] = i < middle ? left : right;
    begin = end;
  }
}

PreparedProfile Prepare(const Profile& profile, const PreprocessOptions& options) {
  if (options.min_columns < 8) {
    throw std::invalid_argument("preprocessing: min_columns must be at least 8");
  }
  PreparedProfile prepared;
  prepared.time_s = profile.time_s;
  prepared.original_m = profile.height_m;
  std::vector<float> height = FilterGeometric(profile.height_m, options.filter);
  const std::size_t m = height.size();
  for (std::size_t i = 0; i < m; ++i) {
    if (!std::isfinite(height[i])) continue;
    if (prepared.points++ == 0) prepared.first_column = static_cast<int>(i);
    prepared.last_column = static_cast<int>(i);
  }
  if (prepared.points < options.min_columns) return prepared;
  if (options.normalise) {
    prepared.curve = FitQuadratic(height);
    const auto [c0, c1, c2] = prepared.curve;
    for (std::size_t i = 0; i < m; ++i) {
      const double u = Mapped(i, m);
      height[i] -= static_cast<float>(c0 + u * (c1 + u * c2));
    }
  }
  FillHoles(height);
  prepared.height_m = std::move(height);
  return prepared;
}

}  // namespace rangegrasp::seam
