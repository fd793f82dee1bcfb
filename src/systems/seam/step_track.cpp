#include "seam/step_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Minimum number of points on each side of a place: fewer do not determine a height.
constexpr double kMinSide = 4.0;
// A parabola and a step have four parameters; windows need more points in total.
constexpr double kParameters = 4.0;
constexpr double kMinStepPoints = 10.0;
// Below these, columns do not determine a parabola, or hardly a step in addition to one.
constexpr double kMinDeterminant = 1e-9;
constexpr double kMinOwnPoints = 1e-3;
// Maximum share of places with a step in their windows at which the step hardly moves the quantile
// below.
constexpr double kFewPlaces = 0.25;
// Only a few wide windows are independent, so their lowest quarter may be low by chance. Narrow
// ones are many: no window's inflation may be less than this share of theirs.
constexpr double kNarrowShare = 0.33;
// A step with more evidence than this is certain. If the greatest evidence of a profile is above
// this, all of its evidence is scaled down to this, so that an edge that ends is soon forgotten.
constexpr double kBeyondDoubt = 15.0;
// In place of the squared t-value: no fit, and more than any value.
constexpr double kNoFit = -1.0;
constexpr double kMost = std::numeric_limits<double>::max();
// Lower limit of the height noise, so that a profile without noise has finite likelihoods.
constexpr double kResolution_mm = 8e-3;
// Share of places that surely have no edge, and chi-squared (1 degree of freedom) there.
constexpr double kQuantile = 0.25;
constexpr double kChiSquared = 0.1015;
// Units in which the sums over powers have similar magnitudes.
constexpr double kMm_1_m = 1e3;
constexpr double kColumns = 100.0;

constexpr int kMedianHalf = 4;

inline float Middle(float a, float b, float c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

// Median of nine: the median of the highest low, the middle median and the lowest high of three
// triples (Paeth 1990).
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

// Median filter. Windows at the ends are as wide as both sides allow.
std::vector<float> Smoothed(const std::vector<float>& z) {
  std::vector<float> smooth(z.size());
  constexpr std::size_t kWhole = 2 * kMedianHalf + 1;
  if (z.size() >= kWhole) {
    MediansOfNine(z.data(), z.size() - kWhole + 1, smooth.data() + kMedianHalf);
  }
  for (std::size_t i = 0; i < z.size(); ++i) {
    const std::size_t half = std::min(i, z.size() - 1 - i);
    if (half >= kMedianHalf) continue;
    const std::span window = std::span(z).subspan(i - half, 2 * half + 1);
    smooth[i] = base::UpperMedianOf(std::vector(window.begin(), window.end()));
  }
  return smooth;
}

// Sums over the points before each place. Places beyond the ends have the sums of the nearest
// place.
struct PlaceSums {
  // 1, x, x^2, x^3, x^4, z, z x, z x^2, z^2 of points at x with height z.
  static constexpr std::size_t kKinds = 9;
  std::size_t places;
  std::size_t pad;
  std::array<std::vector<double>, kKinds> before;

  PlaceSums(std::span<const float> height_m, std::size_t stride, std::size_t widest)
      : places((height_m.size() + stride - 1) / stride), pad(widest) {
    std::vector<int> column;  // of the measured points
    std::vector<float> measured;
    column.reserve(height_m.size());
    measured.reserve(height_m.size());
    for (std::size_t i = 0; i < height_m.size(); ++i) {
      if (!std::isfinite(height_m[i])) continue;
      column.push_back(static_cast<int>(i));
      measured.push_back(height_m[i]);
    }
    const std::vector<float> smooth = Smoothed(measured);
    double mean = 0.0;
    for (const float z : smooth) mean += static_cast<double>(z);
    if (!smooth.empty()) mean /= static_cast<double>(smooth.size());
    for (auto& sums : before) sums.resize(places + 2 * pad);
    std::array<double, kKinds> sum{};
    std::size_t next = 0;
    for (std::size_t place = 0; place < places + pad; ++place) {
      const std::size_t end = place * stride;
      for (; next < smooth.size() && static_cast<std::size_t>(column[next]) < end; ++next) {
        // The middle of a column, which lies between its own place and the next one.
        const double x = (column[next] + 0.5) / kColumns;
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

// Windows of one width, with the least-squares fit in each place's window and the factor that
// reduces their squared t-values.
struct Windows {
  std::size_t half;                                                // [places]
  std::vector<double> points, height_mm, variance_mm2, t_squared;  // t_squared < 0: no fit
  double inflation = 1.0;

  Windows(std::size_t half_width, std::size_t places)
      : half(half_width),
        points(places),
        height_mm(places),
        variance_mm2(places),
        t_squared(places) {}
};

// z = c0 + c1 u + c2 u^2 + h [u >= 0], u = x - place: the parabola is projected out of the step and
// of the heights (Frisch and Waugh 1933); then h is a quotient. Divisions by zero are harmless
// where nothing fits: the loop has no branch, so that it vectorises over places.
RANGEGRASP_VECTORISED void FitWindows(const PlaceSums& sums, double spacing, Windows& fits) {
  const auto before = [&](std::size_t kind) { return sums.before[kind].data() + sums.pad; };
  const double *const n = before(0), *const x = before(1), *const xx = before(2);
  const double *const xxx = before(3), *const xxxx = before(4), *const z = before(5);
  const double *const zx = before(6), *const zxx = before(7), *const zz = before(8);
  double* const points = fits.points.data();
  double* const height = fits.height_mm.data();
  double* const variance = fits.variance_mm2.data();
  double* const t_squared = fits.t_squared.data();
  const auto places = static_cast<int>(sums.places);
  const auto reach = static_cast<int>(fits.half);
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

// Factor by which squared t-values of one window width exceed those of independent residuals.
double Inflation(const std::vector<double>& t_squared) {
  std::vector<double> values = t_squared;
  std::erase_if(values, [](double t2) { return !(t2 >= 0.0); });
  if (values.empty()) return 1.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return std::max(1.0, *at / kChiSquared);
}

// Subtracts a step from the heights in the sums.
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

// The edge itself increases the t-values of all places with the edge in their windows: of all
// places if windows are wide, or if a mould returns light over only 20 mm. The inflation is
// therefore computed from the t-values without the edge.
void TakeOffTheirStep(PlaceSums& sums, double spacing, double min_inflation, Windows& rest,
                      Windows& windows) {
  const std::vector<double>& t_squared = windows.t_squared;
  const auto fitted = std::ranges::count_if(t_squared, [](double t2) { return t2 >= 0.0; });
  if (fitted == 0) return;
  if (2.0 * static_cast<double>(windows.half) < kFewPlaces * static_cast<double>(fitted)) return;
  const auto best = std::ranges::max_element(t_squared);
  const auto place = static_cast<std::size_t>(best - t_squared.begin());
  const double height_mm = windows.height_mm[place];
  TakeOff(place, height_mm, sums);
  rest.half = windows.half;
  FitWindows(sums, spacing, rest);
  TakeOff(place, -height_mm, sums);
  windows.inflation = std::max(min_inflation, Inflation(rest.t_squared));
}

void KeepBetter(const Windows& windows, std::vector<LocalStep>& best) {
  for (std::size_t i = 0; i < best.size(); ++i) {
    const double h = windows.height_mm[i];
    if (windows.t_squared[i] < 0.0) continue;
    const double precision = kMm_1_m * kMm_1_m / (windows.variance_mm2[i] * windows.inflation);
    if (precision > best[i].surest_precision_m2) {
      best[i].surest_height_m = h / kMm_1_m;
      best[i].surest_precision_m2 = precision;
    }
    if (h <= 0.0) continue;
    const double ratio =
        windows.t_squared[i] / (windows.inflation * (windows.points[i] - kParameters));
    // log(1 + x) <= x avoids most logarithms.
    if (0.5 * windows.points[i] * ratio <= best[i].evidence) continue;
    const double evidence = 0.5 * windows.points[i] * std::log1p(ratio);
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

// Removes steps that are too high, and the lower ones that they cause in windows next to them.
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

// ---- tracking ----

// After a longer gap the track is reset.
constexpr double kForget_s = 1.0;
// Positions further from the track than it can have moved plus this [columns] are of another one.
constexpr double kSameTrack_columns = 12.0;
// Minimum standard deviation of motion [places], so that a way can turn.
constexpr double kMinSpread = 0.25;

// Limit of one profile's log-likelihood ratio of the known edge, so that a filament or a hole does
// not look like an end.
constexpr double kMaxRatio = 3.0;
// Limit of the log-odds: four profiles that clearly have no step reverse them.
constexpr double kMaxOdds = 12.0;
// An edge is beyond doubt if, in kSure consecutive profiles that measure it, the log-odds are at
// least kSureOdds and the best way leads to it with kSureShare of the evidence required for an
// edge. An edge that has ended does not reach this by noise, or by a mat's end seen along a turned
// line. All of the evidence would be too much: that of a low edge on a mould fluctuates about it.
constexpr double kSureOdds = 9.0;
constexpr double kSureShare = 0.75;
constexpr int kSure = 10;
// The same after a sure edge disappeared: a mould's flank or a tow may look like an edge for a
// while.
constexpr int kSureAgain = 15;
// Maximum speed of a known edge in addition to the line's motion, as a share of speed_columns_per_s
// (10 mm/s), so that noise does not draw it away.
constexpr double kKnownSpeed = 0.5;
// This limit does not apply at this multiple of the required evidence, which noise never has.
constexpr double kCertain = 2.0;
// If two profiles alone each have an edge, it is the same one within this distance [places: 2 mm].
constexpr double kSameAlone = 8.0;
// A step belongs to the known edge if its height differs by at most this share of it.
constexpr double kSameHeight = 0.5;
// An edge further away than this [places: 3 mm] is another one.
constexpr double kAway = 12.0;
// After this many consecutive profiles, it becomes the known one: a sixth of a second.
constexpr int kElsewhere = 10;
// The known height is the mean over its profiles, later over about the last half second. That of a
// young edge is by chance the highest of all places, so it is corrected at any odds.
constexpr double kHeightGain = 0.03;
constexpr int kYoung = 20;

}  // namespace

std::vector<LocalStep> FitLocalSteps(std::span<const float> height_m,
                                     const LocalStepOptions& options) {
  const auto stride = static_cast<std::size_t>(options.stride);
  const auto half_of = [&](int columns) {
    return std::min((static_cast<std::size_t>(columns) + stride / 2) / stride,
                    height_m.size() / stride + 1);
  };
  const double spacing = static_cast<double>(stride) / kColumns;
  PlaceSums sums(height_m, stride, half_of(std::ranges::max(options.half_windows)));
  std::vector<Windows> widths;
  for (const int columns : options.half_windows) {
    Windows& windows = widths.emplace_back(half_of(columns), sums.places);
    FitWindows(sums, spacing, windows);
    windows.inflation = Inflation(windows.t_squared);
  }
  std::vector<LocalStep> best = BestOf(widths, sums.places);
  const auto beyond_doubt = [](const LocalStep& step) { return step.evidence >= kBeyondDoubt; };
  if (std::ranges::none_of(best, beyond_doubt)) {
    const double min_inflation =
        kNarrowShare * std::ranges::min_element(widths, {}, &Windows::half)->inflation;
    Windows rest(0, sums.places);
    for (Windows& windows : widths) {
      TakeOffTheirStep(sums, spacing, min_inflation, rest, windows);
    }
    best = BestOf(widths, sums.places);
  }
  RemoveHigh(options.max_step_m, half_of(std::ranges::min(options.half_windows)), best);
  return best;
}

StepTrack::StepTrack(const StepTrackOptions& options) : options_(options) {}

// Each place continues the way that leads to it best: its evidence minus the cost of its motion. If
// the line moves by `shift` places, an edge at rest appears `shift` places earlier.
std::vector<StepTrack::Way> StepTrack::Moved(int shift, double period_s) const {
  const double stride = options_.steps.stride;
  const auto places = static_cast<int>(ways_.size());
  const int reach = std::clamp(
      static_cast<int>(std::ceil(options_.max_speed_columns_per_s * period_s / stride)), 1, places);
  const double spread = std::max(options_.speed_columns_per_s * period_s / stride, kMinSpread);
  std::vector<double> best(ways_.size(), 0.0);
  std::vector<int> from(ways_.size());
  for (int place = 0; place < places; ++place) {
    from[static_cast<std::size_t>(place)] = std::clamp(place + shift, 0, places - 1);
  }
  for (int d = -reach; d <= reach; ++d) {
    const double cost = d * d / (2.0 * spread * spread);
    const int to = d + shift;
    for (int place = std::max(0, -to); place < std::min(places, places - to); ++place) {
      const auto here = static_cast<std::size_t>(place);
      const double evidence = ways_[static_cast<std::size_t>(place + to)].evidence - cost;
      if (evidence <= best[here]) continue;
      best[here] = evidence;
      from[here] = place + to;
    }
  }
  std::vector<Way> moved(ways_.size());
  for (std::size_t place = 0; place < moved.size(); ++place) {
    const Way& before = ways_[static_cast<std::size_t>(from[place])];
    moved[place] = {options_.memory * best[place], options_.memory * before.height,
                    options_.memory * before.precision};
  }
  return moved;
}

void StepTrack::Continue(const std::vector<LocalStep>& steps, double strongest, double period_s) {
  const double share = std::min(1.0, kBeyondDoubt / std::max(strongest, 1e-9));
  const int shift = static_cast<int>(std::lround(moved_places_));
  moved_places_ -= shift;
  ways_ = Moved(shift, period_s);
  for (std::size_t place = 0; place < steps.size(); ++place) {
    const LocalStep& step = steps[place];
    ways_[place].evidence += share * step.evidence;
    ways_[place].height += step.precision_m2 * step.height_m;
    ways_[place].precision += step.precision_m2;
  }
  weight_ = options_.memory * weight_ + 1.0;
}

// True if a way has a share of the evidence required for an edge, and the minimum height.
bool StepTrack::Suffices(const Way& way, double share) const {
  const double wanted = options_.evidence + options_.first_evidence / weight_;
  return way.evidence / weight_ >= share * wanted && way.Height() >= options_.min_step_m;
}

// Updates the position of the known edge from the best way.
void StepTrack::Follow(double column, const Way& way, double period_s) {
  const bool sure = Suffices(way, 1.0);
  if (!known_) {
    if (sure) known_ = Known{column, way.Height(), kMaxOdds};
    return;
  }
  const double apart = column - known_->column;
  const double speed = Suffices(way, kCertain) ? options_.max_speed_columns_per_s
                                               : kKnownSpeed * options_.speed_columns_per_s;
  const double reach = speed * period_s;
  if (std::abs(apart) <= kAway * options_.steps.stride) {
    known_->column += std::clamp(apart, -reach, reach);
    known_->elsewhere = 0;
  } else if (sure && ++known_->elsewhere >= kElsewhere) {
    known_ = Known{column, way.Height(), std::min(known_->log_odds, 0.0)};
  }
}

// Updates the odds of the known edge: log-likelihood ratio of a step of its height to none in this
// profile, in the window of highest precision. Also updates the height.
void StepTrack::Weigh(const LocalStep& step) {
  if (!(step.surest_precision_m2 > 0.0)) return;
  const double h = known_->height_m;
  const double varies = options_.uneven * h;
  const double variance = 1.0 / step.surest_precision_m2 + varies * varies;
  const double ratio = 0.5 * h * (2.0 * step.surest_height_m - h) / variance;
  known_->log_odds =
      std::clamp(known_->log_odds + std::clamp(ratio, -kMaxRatio, kMaxRatio), -kMaxOdds, kMaxOdds);
  ++known_->profiles;
  if (known_->log_odds <= 0.0 && known_->profiles > kYoung) return;
  const double now = std::clamp(step.surest_height_m, 0.0, 2.0 * h);
  const double gain = std::max(kHeightGain, 1.0 / known_->profiles);
  known_->height_m = std::max(options_.min_step_m, h + gain * (now - h));
}

// True if the last profiles show the known edge beyond doubt. `there` is this profile's step at its
// place.
bool StepTrack::IsSure(double column, const Way& way, const LocalStep& there) {
  gone_ = gone_ || (was_sure_ && known_->log_odds <= 0.0);
  const bool near = std::abs(column - known_->column) <= kAway * options_.steps.stride;
  if (!near || !Suffices(way, kSureShare) || known_->log_odds < kSureOdds) {
    known_->sure = 0;
  } else if (there.surest_precision_m2 > 0.0) {
    ++known_->sure;
  }
  if (known_->sure < (gone_ ? kSureAgain : kSure)) return false;
  was_sure_ = true;
  gone_ = false;
  return true;
}

// Column of the peak of the parabola through a place's evidence and its neighbors'.
double StepTrack::Peak(std::size_t place) const {
  const double stride = options_.steps.stride;
  if (place == 0 || place + 1 >= ways_.size()) return stride * static_cast<double>(place);
  const double before = ways_[place - 1].evidence;
  const double after = ways_[place + 1].evidence;
  const double bend = before - 2.0 * ways_[place].evidence + after;
  const double offset = bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
  return stride * (static_cast<double>(place) + offset);
}

// Current position on the line through the last positions of this track.
double StepTrack::OnLine(double column, double time_s) {
  positions_.push_back({time_s, column});
  if (static_cast<int>(positions_.size()) > options_.line_profiles) positions_.pop_front();
  std::erase_if(positions_, [&](const TimedColumn& earlier) {
    return std::abs(earlier.column - column) >
           kSameTrack_columns + options_.max_speed_columns_per_s * (time_s - earlier.time_s);
  });
  const std::vector<TimedColumn> track(positions_.begin(), positions_.end());
  return track.size() < 3 ? column : FitLine(track).At(time_s);
}

std::optional<double> StepTrack::AtOnce(std::optional<double> column, const LocalStep& strongest,
                                        double place) {
  const std::optional<double> before = alone_;
  alone_.reset();
  if (!known_ || strongest.evidence < options_.evidence + options_.first_evidence) return column;
  const double apart_m = std::abs(strongest.height_m - known_->height_m);
  if (apart_m > kSameHeight * known_->height_m) return column;
  alone_ = place;
  const double reach = kSameAlone * options_.steps.stride;
  if (column && std::abs(*column - place) <= reach) return column;
  return before && std::abs(*before - place) <= reach ? alone_ : std::nullopt;
}

// The state refers to places on the mats: a line that moves sees them at other columns.
void StepTrack::MoveLine(double columns) {
  moved_places_ += columns / options_.steps.stride;
  for (TimedColumn& position : positions_) position.column -= columns;
  if (known_) known_->column -= columns;
  if (alone_) *alone_ -= columns;
}

StepTrack::Estimate StepTrack::Update(std::span<const float> height_m, double time_s,
                                      double moved_columns) {
  const std::vector<LocalStep> steps = FitLocalSteps(height_m, options_.steps);
  if (!last_time_s_ || time_s - *last_time_s_ > kForget_s || ways_.size() != steps.size()) {
    *this = StepTrack(options_);
    ways_.resize(steps.size());
  }
  Estimate estimate;
  if (steps.empty()) return estimate;
  const auto strongest = std::ranges::max_element(steps, {}, &LocalStep::evidence);
  const double period_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  MoveLine(moved_columns);
  Continue(steps, strongest->evidence, period_s);
  last_time_s_ = time_s;
  if (strongest->evidence > 0.0) {
    estimate.strongest = static_cast<int>(strongest - steps.begin()) * options_.steps.stride;
  }
  const Way& way = *std::ranges::max_element(ways_, {}, &Way::evidence);
  edge_ = Suffices(way, edge_ ? options_.continued : 1.0);
  estimate.step_m = way.Height();
  const double peak = Peak(static_cast<std::size_t>(&way - ways_.data()));
  const double position = OnLine(peak, time_s);
  if (edge_) {
    Follow(peak, way, period_s);
    estimate.column = std::clamp(position, 0.0, static_cast<double>(height_m.size() - 1));
  }
  if (known_) {
    const long place = std::lround(known_->column / options_.steps.stride);
    const LocalStep& there =
        steps[static_cast<std::size_t>(std::clamp(place, 0L, std::ssize(steps) - 1L))];
    Weigh(there);
    estimate.sure = IsSure(peak, way, there);
  }
  estimate.at_once =
      AtOnce(edge_ && Suffices(way, kCertain) ? peak : estimate.column, *strongest,
             static_cast<double>((strongest - steps.begin()) * options_.steps.stride));
  estimate.goes_on = known_ && known_->log_odds > 0.0;
  if (estimate.goes_on) estimate.followed_step_m = std::max(known_->height_m, way.Height());
  return estimate;
}

}  // namespace rangegrasp::seam
