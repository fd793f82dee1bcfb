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
constexpr double kMinStepPoints = 10.0;
// Points whose columns do not determine a parabola, or hardly a step beside one.
constexpr double kMinDeterminant = 1e-9;
constexpr double kMinOwnPoints = 1e-3;
// A step lies in the windows of so few places [share] at most that it hardly moves the quantile
// below.
constexpr double kFewPlaces = 0.25;
// Only few windows that are wide are independent, so that their lowest quarter may be low by
// chance. Narrow ones are many: no window's inflation is less than this share of theirs.
constexpr double kNarrowShare = 0.33;
// Nobody asks for more evidence than this of one profile (StepTrackOptions::most_evidence).
constexpr double kBeyondDoubt = 15.0;
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
    const bool fits_here = (r0 >= kMinSide) & (a0 - r0 >= kMinSide) & (a0 >= kMinStepPoints) &
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

// Takes a step off the heights that the sums are of.
void TakeOff(std::size_t place, double height_mm, PlaceSums& sums) {
  const auto less = [&](std::size_t kind, std::size_t by) {
    const std::vector<double>& its = sums.before[by];
    const std::size_t first = sums.pad + place;
    for (std::size_t i = first; i < its.size(); ++i) {
      sums.before[kind][i] -= height_mm * (its[i] - its[first]);
    }
  };
  less(8, 5);  // (z - h)^2 = z^2 - h z - h (z - h)
  less(5, 0);
  less(8, 5);
  less(6, 1);
  less(7, 2);
}

// The fits in windows of one width, and by how much their t-values are to be lessened.
struct Windows {
  std::size_t half;
  Fits fits;
  double inflation = 1.0;
};

// The edge itself makes the t-values of all places greater whose windows it lies in: of all places
// in wide windows, or on a mould that the light comes back from for 20 mm only. What they would be
// without it tells the inflation.
void TakeOffTheirStep(PlaceSums& sums, double spacing, double min_inflation, Fits& rest,
                      Windows& windows) {
  const std::vector<double>& t_squared = windows.fits.t_squared;
  const auto fitted = std::ranges::count_if(t_squared, [](double t2) { return t2 >= 0.0; });
  if (fitted == 0) return;
  if (2.0 * static_cast<double>(windows.half) < kFewPlaces * static_cast<double>(fitted)) return;
  const auto best = std::ranges::max_element(t_squared);
  const auto place = static_cast<std::size_t>(best - t_squared.begin());
  const double height_mm = windows.fits.height_mm[place];
  TakeOff(place, height_mm, sums);
  FitWindows(sums, windows.half, spacing, rest);
  TakeOff(place, -height_mm, sums);
  windows.inflation = std::max(min_inflation, Inflation(rest.t_squared));
}

void KeepBetter(const Windows& windows, std::vector<LocalStep>& best) {
  const Fits& fits = windows.fits;
  for (std::size_t i = 0; i < best.size(); ++i) {
    const double h = fits.height_mm[i];
    if (fits.t_squared[i] < 0.0) continue;
    const double precision = kMm_1_m * kMm_1_m / (fits.variance_mm2[i] * windows.inflation);
    if (precision > best[i].surest_precision_m2) {
      best[i].surest_height_m = h / kMm_1_m;
      best[i].surest_precision_m2 = precision;
    }
    if (h <= 0.0) continue;
    const double ratio = fits.t_squared[i] / (windows.inflation * (fits.points[i] - kParameters));
    // log(1 + x) <= x spares most logarithms.
    if (0.5 * fits.points[i] * ratio <= best[i].evidence) continue;
    const double evidence = 0.5 * fits.points[i] * std::log1p(ratio);
    if (evidence <= best[i].evidence) continue;
    best[i].evidence = evidence;
    best[i].height_m = h / kMm_1_m;
    best[i].precision_m2 = precision;
  }
}

std::vector<LocalStep> BestOf(const std::vector<Windows>& widths, std::size_t places) {
  std::vector<LocalStep> best(places);
  for (const Windows& windows : widths) KeepBetter(windows, best);
  return best;
}

bool InDoubt(const std::vector<LocalStep>& steps) {
  return std::ranges::none_of(steps,
                              [](const LocalStep& step) { return step.evidence >= kBeyondDoubt; });
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
  if (options.stride < 1 || narrowest < kMinHalfWindow || narrowest < options.stride ||
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
  const double spacing = static_cast<double>(stride) / kColumns;
  PlaceSums sums(height_m, stride, half_of(std::ranges::max(options.half_windows)));
  std::vector<Windows> widths;
  for (const int columns : options.half_windows) {
    Windows& windows = widths.emplace_back(half_of(columns), Fits(sums.places));
    FitWindows(sums, windows.half, spacing, windows.fits);
    windows.inflation = Inflation(windows.fits.t_squared);
  }
  std::vector<LocalStep> best = BestOf(widths, sums.places);
  if (InDoubt(best)) {
    const double min_inflation =
        kNarrowShare * std::ranges::min_element(widths, {}, &Windows::half)->inflation;
    Fits rest(sums.places);
    for (Windows& windows : widths) {
      TakeOffTheirStep(sums, spacing, min_inflation, rest, windows);
    }
    best = BestOf(widths, sums.places);
  }
  RemoveHigh(options.max_step_m, half_of(std::ranges::min(options.half_windows)), best);
  return best;
}

}  // namespace rangegrasp::seam
