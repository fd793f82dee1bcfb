#include "seam/stitching/mats.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/rng.h"
#include "base/units.h"
#include "seam/stitching/internal/filaments.h"
#include "seam/stitching/internal/lattice_noise.h"
#include "seam/stitching/internal/tows.h"

namespace rangegrasp::stitching {
namespace {

using internal::Mix;
using internal::Ramp;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The looks of a frayed edge: a part that varies this much faster, and how strong it is against the
// slow part.
constexpr double kFastFrayRate = 3.0;
constexpr double kFastFray = 0.5;
// An obstacle's border rises over this width, which belongs to its footprint, or over this share of
// its size if that is less.
constexpr double kObstacleBorder_m = 0.2e-3;
constexpr double kObstacleBorderShare = 0.25;
// It is no fibre and is seen well.
constexpr double kObstacleReturn = 0.9;
// A surface that is tilted further is none that a sensor looks down on.
constexpr double kMaxTilt_rad = 1.0;
// From this share of the full height on a filament hides the mat below it.
constexpr double kHidingShare = 0.25;
// Filaments on a black mat return this much less light than on a bright one.
constexpr double kFilamentDarkness = 0.9;

void Check(bool good, const char* option, const char* what) {
  if (!good) throw std::invalid_argument(std::string("mats: ") + option + " must be " + what);
}

// Comparisons are written so that NaN fails them.
void CheckTexture(const MatTexture& t) {
  const char* positive = "above 0";
  const char* not_negative = "0 or more";
  const char* share = "from 0 to 1";
  Check(t.weave_period_m > 0.0, "weave_period_m", positive);
  Check(t.weave_relief_m >= 0.0, "weave_relief_m", not_negative);
  Check(t.fuzz_m >= 0.0, "fuzz_m", not_negative);
  Check(t.fuzz_length_m > 0.0, "fuzz_length_m", positive);
  Check(t.waviness_m >= 0.0, "waviness_m", not_negative);
  Check(t.waviness_length_m > 0.0, "waviness_length_m", positive);
  Check(t.fray_m >= 0.0, "fray_m", not_negative);
  Check(t.fray_length_m > 0.0, "fray_length_m", positive);
  Check(t.filaments_per_m >= 0.0, "filaments_per_m", not_negative);
  Check(t.loose_filaments_per_m2 >= 0.0, "loose_filaments_per_m2", not_negative);
  Check(t.filament_height_m >= 0.0, "filament_height_m", not_negative);
  Check(t.filament_reach_m > 0.0, "filament_reach_m", positive);
  Check(t.detached_share >= 0.0 && t.detached_share <= 1.0, "detached_share", share);
  Check(t.gloss >= 0.0 && t.gloss <= 1.0, "gloss", share);
  Check(t.darkness >= 0.0 && t.darkness <= 1.0, "darkness", share);
  Check(t.steep_rad > 0.0, "steep_rad", positive);
}

void CheckOptions(const MatOptions& o) {
  const char* positive = "above 0";
  Check(o.height_m >= 0.0, "height_m", "0 or more");
  Check(o.edge_width_m > 0.0, "edge_width_m", positive);
  Check(o.slant_width_m > 0.0, "slant_width_m", positive);
  Check(o.double_gap_m >= 0.0, "double_gap_m", "0 or more");
  Check(o.double_share >= 0.0 && o.double_share <= 1.0, "double_share", "from 0 to 1");
  Check(o.radius_m > 0.0, "radius_m", positive);
  Check(std::isfinite(o.mould_x_m), "mould_x_m", "finite");
  Check(std::abs(o.tilt_rad) <= kMaxTilt_rad, "tilt_rad", "from -1 to 1");
  Check(!std::isnan(o.end_y_m), "end_y_m", "a number");
  Check(std::isfinite(o.course.offset_m), "course.offset_m", "finite");
  Check(std::isfinite(o.course.slope), "course.slope", "finite");
  Check(std::isfinite(o.course.half_circle_radius_m), "course.half_circle_radius_m", "finite");
  for (const EdgeCourse::Wave& wave : o.course.waves) {
    Check(wave.length_m > 0.0, "course.waves.length_m", positive);
    Check(std::isfinite(wave.amplitude_m), "course.waves.amplitude_m", "finite");
  }
  for (const MatOptions::Obstacle& obstacle : o.obstacles) {
    Check(obstacle.size_x_m > 0.0 && obstacle.size_y_m > 0.0, "obstacles.size", positive);
    Check(obstacle.height_m > 0.0, "obstacles.height_m", positive);
  }
  CheckTexture(o.texture);
}

/// Height of the mould and its slope's angle.
struct MouldPoint {
  double height_m;
  double slope_rad;
};

// A cylinder up to a slope of 45 degrees, then straight on.
MouldPoint Mould(const MatOptions& options, double x_m) {
  if (options.shape != EdgeShape::kConvex && options.shape != EdgeShape::kConcave)
    return {0.0, 0.0};
  const double r = options.radius_m;
  const double half_m = r * std::sqrt(0.5);
  const double x = std::abs(x_m - options.mould_x_m);
  const double on_arc = std::min(x, half_m);
  const double drop = r - std::sqrt(r * r - on_arc * on_arc) + (x - on_arc);
  const double slope = x < half_m ? std::asin(x / r) : 0.25 * base::kPi;
  const double sign = options.shape == EdgeShape::kConvex ? -1.0 : 1.0;
  return {sign * drop, std::copysign(slope, sign * (x_m - options.mould_x_m))};
}

/// How far the upper mat has risen, and whether its texture is what one sees.
struct Rise {
  double share_of_height;
  double cover;
};

Rise RiseAt(const MatOptions& options, double across_m) {
  const auto step = [&](double s) { return Ramp(s / options.edge_width_m + 0.5); };
  if (options.shape == EdgeShape::kNone) return {0.0, 0.0};
  if (options.shape == EdgeShape::kSlant) {
    const double rise = std::clamp(across_m / options.slant_width_m + 0.5, 0.0, 1.0);
    return {rise, rise};
  }
  const double major = step(across_m);
  if (options.shape != EdgeShape::kDouble) return {major, major};
  const double minor = step(across_m + options.double_gap_m);
  return {Mix(major, minor, options.double_share), minor};
}

double ObstacleWindow(double from_middle_m, double size_m) {
  return Ramp((0.5 * size_m - std::abs(from_middle_m)) /
              std::min(kObstacleBorder_m, kObstacleBorderShare * size_m));
}

}  // namespace

double EdgeCourse::XAt(double y_m) const {
  double x = offset_m + slope * y_m;
  for (const Wave& wave : waves) {
    x += wave.amplitude_m * std::sin(2.0 * base::kPi * y_m / wave.length_m + wave.phase_rad);
  }
  const double dy = y_m - half_circle_y_m;
  const double square = half_circle_radius_m * half_circle_radius_m - dy * dy;
  if (half_circle_radius_m > 0.0 && square > 0.0) x -= std::sqrt(square);
  return x;
}

struct Mats::Impl {
  Impl(const MatOptions& o, std::uint64_t seed)
      : options(o),
        low(o.texture, base::DeriveSeed(seed, "low mat")),
        high(o.texture, base::DeriveSeed(seed, "high mat")),
        filaments(o.texture, o.height_m, seed),
        fray_seed(base::DeriveSeed(seed, "fray")),
        fast_fray_seed(base::DeriveSeed(seed, "fast fray")),
        end_seed(base::DeriveSeed(seed, "end")),
        fray_scale_m(o.texture.fray_m /
                     std::sqrt((1.0 + kFastFray * kFastFray) * internal::kNoiseVariance)),
        has_upper(o.shape != EdgeShape::kNone),
        tan_tilt(std::tan(o.tilt_rad)) {}

  double Edge(double y_m) const {
    const double t = y_m / options.texture.fray_length_m;
    return options.course.XAt(y_m) +
           fray_scale_m * (internal::Noise(fray_seed, t) +
                           kFastFray * internal::Noise(fast_fray_seed, kFastFrayRate * t));
  }

  // How much of the upper mat there is: none beyond its end, which is cut no better than its edge.
  double Presence(double x_m, double y_m) const {
    const double margin = fray_scale_m + options.edge_width_m;  // noise stays within [-1, 1]
    if (y_m < options.end_y_m - margin) return 1.0;
    const double end =
        options.end_y_m +
        fray_scale_m * internal::Noise(end_seed, x_m / options.texture.fray_length_m);
    return Ramp((end - y_m) / options.edge_width_m + 0.5);
  }

  MatPoint Surface(double x_m, double across_m, double y_m, double presence) const {
    Rise rise = RiseAt(options, across_m);
    rise.cover *= presence;
    MatPoint point{0.0, 0.0};
    if (rise.cover < 1.0) point = low.At(x_m, y_m);
    if (rise.cover > 0.0) {
      const MatPoint upper = high.At(x_m, y_m);
      point.height_m = Mix(point.height_m, upper.height_m, rise.cover);
      point.return_strength = Mix(point.return_strength, upper.return_strength, rise.cover);
    }
    point.height_m += options.height_m * rise.share_of_height * presence;
    return point;
  }

  void AddFilament(const MatPoint& filament, double presence, MatPoint& point) const {
    if (filament.height_m <= 0.0) return;
    point.height_m += filament.height_m * presence;
    // Filaments are as dark as the mats; what they lack of the full height shows the mat between.
    const double cover =
        Ramp(filament.height_m / (kHidingShare * options.texture.filament_height_m));
    const double strength =
        filament.return_strength * (1.0 - kFilamentDarkness * options.texture.darkness);
    point.return_strength = Mix(point.return_strength, strength, cover * presence);
  }

  void AddMould(double x_m, MatPoint& point) const {
    const MouldPoint mould = Mould(options, x_m);
    point.height_m += mould.height_m + tan_tilt * x_m;
    const double slope = std::abs(mould.slope_rad + options.tilt_rad);
    const double steep = options.texture.steep_rad;
    point.return_strength *= 1.0 - Ramp(2.0 * slope / steep - 1.0);
  }

  void AddObstacles(double x_m, double y_m, MatPoint& point) const {
    for (const MatOptions::Obstacle& obstacle : options.obstacles) {
      const double window = ObstacleWindow(x_m - obstacle.x_m, obstacle.size_x_m) *
                            ObstacleWindow(y_m - obstacle.y_m, obstacle.size_y_m);
      if (window <= 0.0) continue;
      point.height_m += obstacle.height_m * window;
      point.return_strength = Mix(point.return_strength, kObstacleReturn, window);
    }
  }

  MatOptions options;
  internal::Tows low, high;
  internal::Filaments filaments;
  std::uint64_t fray_seed, fast_fray_seed, end_seed;
  double fray_scale_m;
  bool has_upper;
  double tan_tilt;
};

Mats::Mats(const MatOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  impl_ = std::make_shared<const Impl>(options, seed);
}

const MatOptions& Mats::options() const { return impl_->options; }

MatPoint Mats::At(double x_m, double y_m) const {
  const Impl& mats = *impl_;
  const double across_m = mats.has_upper ? x_m - mats.Edge(y_m) : 0.0;
  const double presence = mats.has_upper ? mats.Presence(x_m, y_m) : 0.0;
  MatPoint point = mats.Surface(x_m, across_m, y_m, presence);
  MatPoint filament = mats.filaments.Elsewhere(x_m, y_m);
  double filament_presence = 1.0;
  if (presence > 0.0) {
    const MatPoint at_edge = mats.filaments.NearEdge(across_m, y_m);
    if (at_edge.height_m * presence > filament.height_m) {
      filament = at_edge;
      filament_presence = presence;
    }
  }
  mats.AddFilament(filament, filament_presence, point);
  mats.AddMould(x_m, point);
  mats.AddObstacles(x_m, y_m, point);
  return point;
}

double Mats::EdgeX(double y_m) const {
  if (!impl_->has_upper || y_m > impl_->options.end_y_m) return kNaN;
  return impl_->Edge(y_m);
}

}  // namespace rangegrasp::stitching
