#include "seam/profile.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/linear_algebra.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Minimum number of points after the filter: an eighth of 1024 columns.
constexpr int kMinPoints = 128;
constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

bool IsFinite(float z) { return std::abs(z) <= std::numeric_limits<float>::max(); }

std::size_t FirstFinite(std::span<const float> z) {
  return static_cast<std::size_t>(std::ranges::find_if(z, IsFinite) - z.begin());
}
// At least one value must be finite.
std::size_t LastFinite(std::span<const float> z) {
  std::size_t last = z.size() - 1;
  while (!IsFinite(z[last])) --last;
  return last;
}

// Sums over the finite points z of columns first .. last, mapped to t in [-1, 1]: t^0 .. t^4, then
// z t^0 .. z t^2. Even and odd columns are summed in parallel, which is faster, and always in the
// same order.
std::array<double, 8> MomentsOf(std::span<const float> height_m, std::size_t first,
                                std::size_t last) {
  constexpr std::size_t kLanes = 2;
  double sums[8][kLanes] = {};
  const double scale = 2.0 / static_cast<double>(last - first);
  const std::size_t pairs = (last - first + 1 + kLanes - 1) / kLanes;
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t offset = kLanes * pair + lane;
      const float height = offset <= last - first ? height_m[first + offset] : kMissing;
      const bool there = IsFinite(height);
      const double one = there ? 1.0 : 0.0;
      const double z = there ? static_cast<double>(height) : 0.0;
      const double t = static_cast<double>(static_cast<std::int32_t>(offset)) * scale - 1.0;
      const double t1 = one * t;
      const double t2 = t1 * t;
      sums[0][lane] += one;
      sums[1][lane] += t1;
      sums[2][lane] += t2;
      sums[3][lane] += t2 * t;
      sums[4][lane] += t2 * t2;
      sums[5][lane] += z;
      sums[6][lane] += z * t;
      sums[7][lane] += z * t2;
    }
  }
  std::array<double, 8> moments;
  for (std::size_t k = 0; k < moments.size(); ++k) moments[k] = sums[k][0] + sums[k][1];
  return moments;
}

// Converts c0 + c1 t + c2 t^2 with t = p u + q to powers of u.
std::array<double, 3> Substitute(const std::array<double, 3>& c, double p, double q) {
  return {c[0] + q * (c[1] + q * c[2]), p * (c[1] + 2.0 * q * c[2]), p * p * c[2]};
}

void Subtract(const std::array<double, 3>& c, std::span<float> height_m) {
  const double scale = 2.0 / static_cast<double>(height_m.size() - 1);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(height_m.size()); ++i) {
    const double u = i * scale - 1.0;
    height_m[static_cast<std::size_t>(i)] -= static_cast<float>(c[0] + u * (c[1] + u * c[2]));
  }
}

// Scales min_neighbors: if half of a profile is missing, points have half the neighbors.
FilterOptions ForDensity(FilterOptions options, std::span<const float> height_m) {
  if (height_m.empty()) return options;
  const auto points = std::count_if(height_m.begin(), height_m.end(), IsFinite);
  const double share = static_cast<double>(points) / static_cast<double>(height_m.size());
  options.min_neighbors = static_cast<int>(std::ceil(options.min_neighbors * share));
  return options;
}

// Counts, for each column, the other points within reach and within half_height of it. The inner
// loop is over columns, so that it vectorises. Comparisons with NaN are false.
RANGEGRASP_VECTORISED void CountNeighbors(const float* z, std::size_t columns, std::size_t reach,
                                          float half_height, int* neighbors) {
  for (std::size_t d = 1; d <= reach; ++d) {
    const float* right = z + d;
    const float* left = z - d;
    for (std::size_t i = 0; i < columns; ++i) {
      neighbors[i] += std::abs(right[i] - z[i]) <= half_height ? 1 : 0;
      neighbors[i] += std::abs(left[i] - z[i]) <= half_height ? 1 : 0;
    }
  }
}

}  // namespace

std::vector<float> FilterGeometric(std::span<const float> height_m, const FilterOptions& options) {
  const std::size_t m = height_m.size();
  const auto reach = std::min(static_cast<std::size_t>(options.half_width_columns), m);
  const auto half_height = static_cast<float>(options.half_height_m);
  std::vector<float> padded(m + 2 * reach, kMissing);
  std::copy(height_m.begin(), height_m.end(), padded.begin() + static_cast<std::ptrdiff_t>(reach));
  std::vector<int> neighbors(m);
  CountNeighbors(padded.data() + reach, m, reach, half_height, neighbors.data());
  std::vector<float> kept(m, kMissing);
  for (std::size_t i = 0; i < m; ++i) {
    if (neighbors[i] >= options.min_neighbors && IsFinite(height_m[i])) kept[i] = height_m[i];
  }
  return kept;
}

std::array<double, 3> FitQuadratic(std::span<const float> height_m) {
  const std::size_t m = height_m.size();
  const std::size_t first = FirstFinite(height_m);
  if (first == m) return {};
  const std::size_t last = LastFinite(height_m);
  if (first == last) return {static_cast<double>(height_m[first]), 0.0, 0.0};
  const auto s = MomentsOf(height_m, first, last);
  std::array<double, 3> c{};
  if (s[0] == 2.0) {
    const auto left = static_cast<double>(height_m[first]);
    const auto right = static_cast<double>(height_m[last]);
    c = {0.5 * (left + right), 0.5 * (right - left), 0.0};
  } else {
    Eigen::Matrix3d normal;
    normal << s[0], s[1], s[2], s[1], s[2], s[3], s[2], s[3], s[4];
    const Eigen::Vector3d solved =
        base::SolveLdlt<3, 1>(normal, Eigen::Map<const Eigen::Vector3d>(s.data() + 5));
    c = {solved.x(), solved.y(), solved.z()};
  }
  const auto width = static_cast<double>(last - first);
  const auto whole = static_cast<double>(m - 1);
  return Substitute(c, whole / width, (whole - static_cast<double>(first + last)) / width);
}

void FillHoles(std::span<float> height_m) {
  const std::size_t m = height_m.size();
  std::size_t begin = 0;
  while (begin < m) {
    if (IsFinite(height_m[begin])) {
      ++begin;
      continue;
    }
    std::size_t end = begin;
    while (end < m && !IsFinite(height_m[end])) ++end;
    if (begin == 0 && end == m) return;
    const float left = begin > 0 ? height_m[begin - 1] : height_m[end];
    const float right = end < m ? height_m[end] : left;
    const std::size_t middle = begin + (end - begin) / 2;
    for (std::size_t i = begin; i < end; ++i) height_m[i] = i < middle ? left : right;
    begin = end;
  }
}

PreparedProfile Prepare(const Profile& profile, const FilterOptions& options) {
  PreparedProfile prepared;
  prepared.time_s = profile.time_s;
  prepared.moved_m = profile.moved_m;
  prepared.original_m = profile.height_m;
  std::vector<float> height =
      FilterGeometric(profile.height_m, ForDensity(options, profile.height_m));
  const auto points = std::ranges::count_if(height, IsFinite);
  if (points > 0) {
    prepared.first_column = static_cast<int>(FirstFinite(height));
    prepared.last_column = static_cast<int>(LastFinite(height));
  }
  if (points < kMinPoints) return prepared;
  Subtract(FitQuadratic(height), height);
  FillHoles(height);
  prepared.height_m = std::move(height);
  return prepared;
}

}  // namespace rangegrasp::seam
