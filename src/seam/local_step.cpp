#include "seam/local_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Points on each side of a place, at least: fewer tell no height.
constexpr double kMinSide = 4.0;
// Nor do windows with fewer points altogether: a parabola and a step have four parameters.
constexpr double kParameters = 4.0;
constexpr double kMinPoints = 10.0;
// Points whose columns do not determine a parabola, or hardly a step beside one.
constexpr double kMinDeterminant = 1e-9;
constexpr double kMinOwnPoints = 1e-3;
// In place of the squared t-value where nothing fits, and beyond all of them.
constexpr double kNoFit = -1.0;
constexpr double kMost = std::numeric_limits<double>::max();
// Heights are not known better than this, so that a profile without noise has finite likelihoods.
constexpr double kResolution_mm = 8e-3;
// The share of places that surely hold no edge, and the chi-squared (1 degree of freedom) there.
constexpr double kQuantile = 0.25;
constexpr double kChiSquared = 0.1015;
// Sums over powers stay of one size in these units.
constexpr double kMm_1_m = 1e3;
constexpr double kColumns = 100.0;

constexpr int kMedianHalf = 4;

struct Points {
  std::vector<int> column;
  std::vector<float> height_m;
};

Points Measured(std::span<const float> height_m) {
  Points points;
  points.column.reserve(height_m.size());
  points.height_m.reserve(height_m.size());
  for (std::size_t i = 0; i < height_m.size(); ++i) {
    if (!std::isfinite(height_m[i])) continue;
    points.column.push_back(static_cast<int>(i));
    points.height_m.push_back(height_m[i]);
  }
  return points;
}

inline float Middle(float a, float b, float c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

// The middle of nine: that of the highest low, the middle middle and the lowest high one of three
// threes (Paeth 1990).
RANGEGRASP_VECTORISED void MediansOfNine(const float* z, std::size_t count, float* median) {
  for (std::size_t i = 0; i < count; ++i) {
    const float* v = z + i;
    const float low = std::max(
        {std::min({v[0], v[1], v[2]}), std::min({v[3], v[4], v[5]}), std::min({v[6], v[7], v[8]})});
    const float middle =
        Middle(Middle(v[0], v[1], v[2]), Middle(v[3], v[4], v[5]), Middle(v[6], v[7], v[8]));
    const float high = std::min(
        {std::max({v[0], v[1], v[2]}), std::max({v[3], v[4], v[5]}), std::max({v[6], v[7], v[8]})});
    median[i] = Middle(low, middle, high);
  }
}

// Windows at the ends are as wide as both sides allow.
std::vector<float> Smoothed(const std::vector<float>& z) {
  std::vector<float> smooth(z.size());
  constexpr std::size_t kWhole = 2 * kMedianHalf + 1;
  if (z.size() >= kWhole) {
    MediansOfNine(z.data(), z.size() - kWhole + 1, smooth.data() + kMedianHalf);
  }
  for (std::size_t i = 0; i < z.size(); ++i) {
    const std::size_t half = std::min(i, z.size() - 1 - i);
    if (half >= kMedianHalf) continue;
    std::vector<float> window(z.begin() + static_cast<std::ptrdiff_t>(i - half),
                              z.begin() + static_cast<std::ptrdiff_t>(i + half + 1));
    std::nth_element(window.begin(), window.begin() + static_cast<std::ptrdiff_t>(half),
                     window.end());
    smooth[i] = window[half];
  }
  return smooth;
}

// Sums over the points before each place; the numbers of places beyond the ends go on with the
// nearest's.
struct PlaceSums {
  // 1, x, x^2, x^3, x^4, z, z x, z x^2, z^2 of points at x with height z.
  static constexpr std::size_t kKinds = 9;
  std::size_t places;
  std::size_t pad;
  std::array<std::vector<double>, kKinds> before;

  PlaceSums(std::span<const float> height_m, std::size_t stride, std::size_t widest)
      : places((height_m.size() + stride - 1) / stride), pad(widest) {
    const Points points = Measured(height_m);
    const std::vector<float> smooth = Smoothed(points.height_m);
    double mean = 0.0;
    for (const float z : smooth) mean += static_cast<double>(z);
    if (!smooth.empty()) mean /= static_cast<double>(smooth.size());
    for (auto& sums : before) sums.resize(places + 2 * pad);
    std::array<double, kKinds> sum{};
    std::size_t next = 0;
    for (std::size_t place = 0; place < places + pad; ++place) {
      const std::size_t end = place * stride;
      for (; next < smooth.size() && static_cast<std::size_t>(points.column[next]) < end; ++next) {
        // A column lies between its own place and the next one.
        const double x = (points.column[next] + 0.5) / kColumns;
        const double z = (static_cast<double>(smooth[next]) - mean) * kMm_1_m;
        const double x2 = x * x;
        const std::array<double, kKinds> terms = {1.0, x,     x2,     x2 * x, x2 * x2,
                                                  z,   z * x, z * x2, z * z};
        for (std::size_t kind = 0; kind < kKinds; ++kind) sum[kind] += terms[kind];
      }
      for (std::size_t kind = 0; kind < kKinds; ++kind) before[kind][pad + place] = sum[kind];
    }
  }
};

// What the least-squares fits in windows of one width say, place after place.
struct Fits {
  std::vector<double> points, height_mm, variance_mm2, t_squared;  // t_squared < 0: no fit

  explicit Fits(std::size_t places)
      : points(places), height_mm(places), variance_mm2(places), t_squared(places) {}
};

// z = c0 + c1 u + c2 u^2 + h [u >= 0], u = x - place: the parabola is taken out of the step and of
// the heights (Frisch and Waugh 1933), then h is a quotient. Where nothing fits, divisions by zero
// do no harm: the loop has no branch, so that places are computed side by side.
RANGEGRASP_VECTORISED void FitWindows(const PlaceSums& sums, std::size_t half, double spacing,
                                      Fits& fits) {
  const auto before = [&](std::size_t kind) { return sums.before[kind].data() + sums.pad; };
  const double* const n = before(0);
  const double* const x = before(1);
  const double* const xx = before(2);
  const double* const xxx = before(3);
  const double* const xxxx = before(4);
  const double* const z = before(5);
  const double* const zx = before(6);
  const double* const zxx = before(7);
  const double* const zz = before(8);
  double* const points = fits.points.data();
  double* const height = fits.height_mm.data();
  double* const variance = fits.variance_mm2.data();
  double* const t_squared = fits.t_squared.data();
  const auto places = static_cast<int>(sums.places);
  const auto reach = static_cast<int>(half);
#pragma GCC ivdep
  for (int place = 0; place < places; ++place) {
    const auto all = [=](const double* sum) { return sum[place + reach] - sum[place - reach]; };
    const auto right = [=](const double* sum) { return sum[place + reach] - sum[place]; };
    // Moments about the place.
    const double c = place * spacing;
    const double c2 = c * c;
    const double a0 = all(n);
    const double a1 = all(x) - c * a0;
    const double a2 = all(xx) - 2.0 * c * all(x) + c2 * a0;
    const double a3 = all(xxx) - 3.0 * c * all(xx) + 3.0 * c2 * all(x) - c2 * c * a0;
    const double a4 =
        all(xxxx) - 4.0 * c * all(xxx) + 6.0 * c2 * all(xx) - 4.0 * c2 * c * all(x) + c2 * c2 * a0;
    const double z0 = all(z);
    const double z1 = all(zx) - c * z0;
    const double z2 = all(zxx) - 2.0 * c * all(zx) + c2 * z0;
    const double r0 = right(n);
    const double r1 = right(x) - c * r0;
    const double r2 = right(xx) - 2.0 * c * right(x) + c2 * r0;
    // Adjugate of the parabola's normal matrix.
    const double d00 = a2 * a4 - a3 * a3;
    const double d01 = a2 * a3 - a1 * a4;
    const double d02 = a1 * a3 - a2 * a2;
    const double d11 = a0 * a4 - a2 * a2;
    const double d12 = a1 * a2 - a0 * a3;
    const double d22 = a0 * a2 - a1 * a1;
    const double determinant = a0 * d00 + a1 * d01 + a2 * d02;
    const double scale = 1.0 / determinant;
    const double step0 = (d00 * r0 + d01 * r1 + d02 * r2) * scale;
    const double step1 = (d01 * r0 + d11 * r1 + d12 * r2) * scale;
    const double step2 = (d02 * r0 + d12 * r1 + d22 * r2) * scale;
    const double own = r0 - (step0 * r0 + step1 * r1 + step2 * r2);
    const double own_height = right(z) - (step0 * z0 + step1 * z1 + step2 * z2);
    const double flat0 = (d00 * z0 + d01 * z1 + d02 * z2) * scale;
    const double flat1 = (d01 * z0 + d11 * z1 + d12 * z2) * scale;
    const double flat2 = (d02 * z0 + d12 * z1 + d22 * z2) * scale;
    const double residual = all(zz) - (flat0 * z0 + flat1 * z1 + flat2 * z2);
    const double h = own_height / own;
    const double left_over =
        std::max(residual - h * own_height, 0.0) + a0 * kResolution_mm * kResolution_mm;
    const double its_variance = left_over / (a0 - kParameters) / own;
    const bool fits_here = (r0 >= kMinSide) & (a0 - r0 >= kMinSide) & (a0 >= kMinPoints) &
                           (determinant > kMinDeterminant * a0 * a2 * a4) & (own > kMinOwnPoints);
    points[place] = a0;
    height[place] = h;
    variance[place] = its_variance;
    t_squared[place] = std::min(fits_here ? kMost : kNoFit, h * h / its_variance);
  }
}

// By how much the t-values of a window's width are greater than those of independent residuals.
double Inflation(const std::vector<double>& t_squared) {
  std::vector<double> values;
  values.reserve(t_squared.size());
  std::copy_if(t_squared.begin(), t_squared.end(), std::back_inserter(values),
               [](double t2) { return t2 >= 0.0; });
  if (values.empty()) return 1.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return std::max(1.0, *at / kChiSquared);
}

void KeepBetter(const Fits& fits, std::vector<LocalStep>& best) {
  const double inflation = Inflation(fits.t_squared);
  for (std::size_t i = 0; i < best.size(); ++i) {
    const double h = fits.height_mm[i];
    if (fits.t_squared[i] < 0.0) continue;
    const double precision = kMm_1_m * kMm_1_m / (fits.variance_mm2[i] * inflation);
    if (precision > best[i].surest_precision_m2) {
      best[i].surest_height_m = h / kMm_1_m;
      best[i].surest_precision_m2 = precision;
    }
    if (h <= 0.0) continue;
    const double ratio = fits.t_squared[i] / (inflation * (fits.points[i] - kParameters));
    // log(1 + x) <= x spares most logarithms.
    if (0.5 * fits.points[i] * ratio <= best[i].evidence) continue;
    const double evidence = 0.5 * fits.points[i] * std::log1p(ratio);
    if (evidence <= best[i].evidence) continue;
    best[i].evidence = evidence;
    best[i].height_m = h / kMm_1_m;
    best[i].precision_m2 = precision;
  }
}

// Steps that are too high are none, nor are the lower ones that windows beside them see.
void RemoveHigh(double max_step_m, std::size_t beside, std::vector<LocalStep>& steps) {
  std::vector<bool> none(steps.size(), false);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].height_m <= max_step_m) continue;
    const std::size_t end = std::min(steps.size(), i + beside + 1);
    for (std::size_t k = i - std::min(i, beside); k < end; ++k) {
      if (steps[k].evidence <= steps[i].evidence) none[k] = true;
    }
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (none[i]) steps[i] = {};
  }
}

}  // namespace

void CheckOptions(const LocalStepOptions& options) {
  const int narrowest = std::ranges::min(options.half_windows);
  if (options.stride < 1 || narrowest < 4 || narrowest < options.stride ||
      !(options.max_step_m > 0.0)) {
    throw std::invalid_argument(
        "local step: stride must be at least 1, half windows at least 4 and the stride, max_step_m "
        "above 0");
  }
}

std::vector<LocalStep> FitLocalSteps(std::span<const float> height_m,
                                     const LocalStepOptions& options) {
  CheckOptions(options);
  const auto stride = static_cast<std::size_t>(options.stride);
  const auto half_of = [&](int columns) {
    return std::min((static_cast<std::size_t>(columns) + stride / 2) / stride,
                    height_m.size() / stride + 1);
  };
  const PlaceSums sums(height_m, stride, half_of(std::ranges::max(options.half_windows)));
  std::vector<LocalStep> best(sums.places);
  Fits fits(sums.places);
  for (const int columns : options.half_windows) {
    FitWindows(sums, half_of(columns), static_cast<double>(stride) / kColumns, fits);
    KeepBetter(fits, best);
  }
  RemoveHigh(options.max_step_m, half_of(std::ranges::min(options.half_windows)), best);
  return best;
}

}  // namespace rangegrasp::seam
