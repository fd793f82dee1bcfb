#include "stitching/mats.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace rangegrasp::stitching {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = std::numbers::pi;

// What a hashed number is for; each use has its own.
enum Salt : std::uint64_t { kFray, kFuzz, kTow, kWeave, kEdgeFilament, kLooseFilament, kBundle };

// SplitMix64's finaliser: textures need a hash that is cheap, many times a point.
std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

std::uint64_t Hash(std::uint64_t seed, Salt salt, std::int64_t a, std::int64_t b = 0) {
  const auto ua = static_cast<std::uint64_t>(a) * 0x9e3779b97f4a7c15U;
  const auto ub = static_cast<std::uint64_t>(b) * 0xc2b2ae3d27d4eb4fU;
  return Mix(seed ^ Mix(ua + ub + salt * 0x165667b19e3779f9U));
}

// Uniform numbers drawn one after the other from one hash.
class Draws {
 public:
  explicit Draws(std::uint64_t state) : state_(state) {}
  double Uniform() {
    state_ += 0x9e3779b97f4a7c15U;
    return static_cast<double>(Mix(state_) >> 11U) * 0x1.0p-53;
  }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }

 private:
  std::uint64_t state_;
};

double Lattice(std::uint64_t seed, Salt salt, std::int64_t a, std::int64_t b = 0) {
  return static_cast<double>(Hash(seed, salt, a, b) >> 11U) * 0x1.0p-52 - 1.0;
}

double Smooth(double t) { return t * t * (3.0 - 2.0 * t); }
double SmoothStep(double t) { return Smooth(std::clamp(t, 0.0, 1.0)); }

// Smooth noise between hashed values at whole numbers, within [-1, 1].
double Noise(std::uint64_t seed, Salt salt, double x) {
  const double cell = std::floor(x);
  const auto i = static_cast<std::int64_t>(cell);
  return std::lerp(Lattice(seed, salt, i), Lattice(seed, salt, i + 1), Smooth(x - cell));
}

double Noise(std::uint64_t seed, Salt salt, double x, double y) {
  const double cx = std::floor(x);
  const double cy = std::floor(y);
  const auto i = static_cast<std::int64_t>(cx);
  const auto j = static_cast<std::int64_t>(cy);
  const double tx = Smooth(x - cx);
  const double low = std::lerp(Lattice(seed, salt, i, j), Lattice(seed, salt, i + 1, j), tx);
  const double high =
      std::lerp(Lattice(seed, salt, i, j + 1), Lattice(seed, salt, i + 1, j + 1), tx);
  return std::lerp(low, high, Smooth(y - cy));
}

// How many things a cell holds when it holds `mean` on the average.
int CountIn(double mean, Draws& draws) {
  const double whole = std::floor(mean);
  return static_cast<int>(whole) + (draws.Uniform() < mean - whole ? 1 : 0);
}

// ---- filaments: thin ridges ----

constexpr double kFilamentCell_m = 2e-3;      // along an edge
constexpr double kLooseCell_m = 4e-3;         // elsewhere
constexpr double kFilamentSpread_m = 1.5e-3;  // mean distance from the edge
constexpr double kLongestHalf_m = 4e-3;

struct Filament {
  double x, y, half_length, lean, half_width, height;

  double HeightAt(double at_x, double at_y) const {
    const double along = (at_y - y) / half_length;
    if (std::abs(along) >= 1.0) return 0.0;
    const double across = (at_x - x - lean * (at_y - y)) / half_width;
    if (std::abs(across) >= 1.0) return 0.0;
    return height * (1.0 - along * along) * (1.0 - across * across);
  }
};

Filament DrawFilament(double x, double y, double height, Draws& draws) {
  Filament filament{};
  filament.x = x;
  filament.y = y;
  filament.half_length = draws.Uniform(0.5e-3, kLongestHalf_m);
  filament.lean = draws.Uniform(-1.0, 1.0);
  filament.half_width = draws.Uniform(0.05e-3, 0.2e-3);
  filament.height = height * draws.Uniform(0.3, 1.3);
  return filament;
}

double EdgeFilaments(const MatTexture& t, std::uint64_t seed, double x_from_edge, double y) {
  // No filament is further off than this; most columns need look no further.
  if (t.filaments_per_m <= 0.0 || std::abs(x_from_edge) > 6.0 * kFilamentSpread_m) return 0.0;
  const auto here = static_cast<std::int64_t>(std::floor(y / kFilamentCell_m));
  const auto reach = static_cast<std::int64_t>(std::ceil(kLongestHalf_m / kFilamentCell_m));
  double height = 0.0;
  for (std::int64_t cell = here - reach; cell <= here + reach; ++cell) {
    Draws draws(Hash(seed, kEdgeFilament, cell));
    const int count = CountIn(t.filaments_per_m * kFilamentCell_m, draws);
    for (int k = 0; k < count; ++k) {
      const double side = draws.Uniform() < 0.5 ? -1.0 : 1.0;
      const double off = -kFilamentSpread_m * std::log(1.0 - 0.95 * draws.Uniform());
      const double at_y = (static_cast<double>(cell) + draws.Uniform()) * kFilamentCell_m;
      const Filament f = DrawFilament(side * off, at_y, t.filament_height_m, draws);
      height = std::max(height, f.HeightAt(x_from_edge, y));
    }
  }
  return height;
}

double LooseFilaments(const MatTexture& t, std::uint64_t seed, double x, double y) {
  if (t.loose_filaments_per_m2 <= 0.0) return 0.0;
  const auto i = static_cast<std::int64_t>(std::floor(x / kLooseCell_m));
  const auto j = static_cast<std::int64_t>(std::floor(y / kLooseCell_m));
  double height = 0.0;
  for (std::int64_t cx = i - 1; cx <= i + 1; ++cx) {
    for (std::int64_t cy = j - 1; cy <= j + 1; ++cy) {
      Draws draws(Hash(seed, kLooseFilament, cx, cy));
      const int count = CountIn(t.loose_filaments_per_m2 * kLooseCell_m * kLooseCell_m, draws);
      for (int k = 0; k < count; ++k) {
        const double fx = (static_cast<double>(cx) + draws.Uniform()) * kLooseCell_m;
        const double fy = (static_cast<double>(cy) + draws.Uniform()) * kLooseCell_m;
        const Filament f = DrawFilament(fx, fy, t.filament_height_m, draws);
        height = std::max(height, f.HeightAt(x, y));
      }
    }
  }
  return height;
}

// A bundle of fibres that has come off the edge: a ridge of its own beside it, on the low side.
double DetachedBundle(const MatOptions& o, std::uint64_t seed, double x_from_edge, double y) {
  constexpr double kCell_m = 8e-3;
  constexpr double kHalfWidth_m = 0.4e-3;
  if (x_from_edge > 0.0 || x_from_edge < -4e-3) return 0.0;
  const double cell = std::floor(y / kCell_m);
  Draws draws(Hash(seed, kBundle, static_cast<std::int64_t>(cell)));
  if (draws.Uniform() >= o.texture.detached_share) return 0.0;
  const double off = draws.Uniform(1e-3, 3e-3);
  const double height = o.height_m * draws.Uniform(0.5, 1.0);
  const double across = (x_from_edge + off) / kHalfWidth_m;
  if (std::abs(across) >= 1.0) return 0.0;
  const double along = 2.0 * (y / kCell_m - cell) - 1.0;  // -1 .. 1 over the cell
  return height * (1.0 - across * across) * SmoothStep(4.0 * (1.0 - std::abs(along)));
}

// ---- the woven surface ----

struct Weave {
  double relief_m;
  double strength;  // of the light that comes back
};

// Plain weave: tows along u and v go over and under in turn. A glossy tow sends the light away
// where it lies on top.
Weave WeaveAt(const MatTexture& t, std::uint64_t seed, double x, double y) {
  const double angle = 0.5 * kPi * Lattice(seed, kWeave, 0);
  const double u = (std::cos(angle) * x + std::sin(angle) * y) / t.weave_period_m;
  const double v = (-std::sin(angle) * x + std::cos(angle) * y) / t.weave_period_m;
  const auto i = static_cast<std::int64_t>(std::floor(u));
  const auto j = static_cast<std::int64_t>(std::floor(v));
  Draws draws(Hash(seed, kTow, i, j));
  const double strength =
      draws.Uniform() < t.gloss * 0.5 ? draws.Uniform(0.05, 0.4) : draws.Uniform(0.7, 1.0);
  return {t.weave_relief_m * std::sin(kPi * u) * std::sin(kPi * v),
          strength * (1.0 - 0.7 * t.darkness)};
}

// ---- the mould below ----

struct Mould {
  double height_m;
  double slope;
};

// A cylinder along y, going on along its tangent beyond 45 degrees.
Mould CylinderAt(double radius, double dx) {
  const double limit = radius * std::numbers::sqrt2 / 2.0;
  const double inside = std::clamp(dx, -limit, limit);
  const double height = std::sqrt(radius * radius - inside * inside) - radius;
  const double slope = -inside / std::sqrt(radius * radius - inside * inside);
  return {height + slope * (dx - inside), slope};
}

Mould MouldAt(const MatOptions& o, double x) {
  Mould mould{o.tilt_rad * x, o.tilt_rad};
  if (o.shape != EdgeShape::kConvex && o.shape != EdgeShape::kConcave) return mould;
  const double sign = o.shape == EdgeShape::kConvex ? 1.0 : -1.0;
  const Mould cylinder = CylinderAt(o.radius_m, x - o.course.offset_m);
  return {mould.height_m + sign * cylinder.height_m, mould.slope + sign * cylinder.slope};
}

// Light that comes back from a slope: all up to 30 degrees, none from 50 on.
double SlopeStrength(double slope) {
  const double angle = std::atan(std::abs(slope));
  return 1.0 - SmoothStep((angle - kPi / 6.0) / (kPi / 9.0));
}

// The upper mat's share of its full height at a distance from its edge.
double Rise(const MatOptions& o, double d) {
  const auto step = [&](double at) { return SmoothStep((d - at) / o.edge_width_m + 0.5); };
  switch (o.shape) {
    case EdgeShape::kNone:
      return 0.0;
    case EdgeShape::kSlant:
      return std::clamp(d / o.slant_width_m + 0.5, 0.0, 1.0);
    case EdgeShape::kDouble:
      return (1.0 - o.double_share) * step(0.0) + o.double_share * step(-o.double_gap_m);
    default:
      return step(0.0);
  }
}

constexpr double kRounding_m = 0.3e-3;  // of an obstacle's border

double ObstacleHeight(const MatOptions::Obstacle& obstacle, double x, double y) {
  const double in_x = 0.5 * obstacle.size_x_m - std::abs(x - obstacle.x_m);
  const double in_y = 0.5 * obstacle.size_y_m - std::abs(y - obstacle.y_m);
  if (in_x <= 0.0 || in_y <= 0.0) return 0.0;
  return obstacle.height_m * SmoothStep(in_x / kRounding_m) * SmoothStep(in_y / kRounding_m);
}

void Check(const MatOptions& o) {
  const auto check = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument(std::string("mats: ") + what);
  };
  check(o.height_m >= 0.0, "height_m must not be negative");
  check(o.edge_width_m > 0.0, "edge_width_m must be above 0");
  check(o.slant_width_m > 0.0, "slant_width_m must be above 0");
  check(o.radius_m > 0.0, "radius_m must be above 0");
  check(o.double_share >= 0.0 && o.double_share <= 1.0, "double_share must be from 0 to 1");
  check(o.texture.weave_period_m > 0.0, "texture.weave_period_m must be above 0");
  check(o.texture.fray_length_m > 0.0, "texture.fray_length_m must be above 0");
}

}  // namespace

const char* Name(EdgeShape shape) {
  switch (shape) {
    case EdgeShape::kStep:
      return "step";
    case EdgeShape::kDouble:
      return "double";
    case EdgeShape::kSlant:
      return "slant";
    case EdgeShape::kConvex:
      return "convex";
    case EdgeShape::kConcave:
      return "concave";
    case EdgeShape::kNone:
      return "none";
  }
  return "?";
}

double EdgeCourse::XAt(double y_m) const {
  double x = offset_m + slope * y_m;
  for (const Wave& wave : waves) {
    x += wave.amplitude_m * std::sin(2.0 * kPi * y_m / wave.length_m + wave.phase_rad);
  }
  const double from_middle = y_m - half_circle_y_m;
  if (std::abs(from_middle) < half_circle_radius_m) {
    x -= std::sqrt(half_circle_radius_m * half_circle_radius_m - from_middle * from_middle);
  }
  return x;
}

Mats::Mats(const MatOptions& options, std::uint64_t seed) : options_(options), seed_(seed) {
  Check(options);
}

double Mats::EdgeX(double y_m) const {
  if (options_.shape == EdgeShape::kNone || y_m > options_.end_y_m) return kNone;
  // Smooth noise between values uniform in [-1, 1] has a standard deviation of about 0.48.
  const double fray =
      options_.texture.fray_m / 0.48 * Noise(seed_, kFray, y_m / options_.texture.fray_length_m);
  return options_.course.XAt(y_m) + fray;
}

MatPoint Mats::At(double x_m, double y_m) const {
  const MatTexture& t = options_.texture;
  const Mould mould = MouldAt(options_, x_m);
  const double edge = EdgeX(y_m);
  const double from_edge = x_m - edge;  // NaN without an edge: then nothing below is taken
  const double rise = std::isnan(edge) ? 0.0 : Rise(options_, from_edge);
  // The two mats are woven apart.
  const Weave weave = WeaveAt(t, rise > 0.5 ? seed_ + 1 : seed_, x_m, y_m);
  double height = mould.height_m + options_.height_m * rise + weave.relief_m;
  constexpr double kFuzzCell_m = 0.15e-3;
  if (t.fuzz_m > 0.0)
    height += t.fuzz_m * Noise(seed_, kFuzz, x_m / kFuzzCell_m, y_m / kFuzzCell_m);
  double stands_off = LooseFilaments(t, seed_, x_m, y_m);
  if (!std::isnan(edge)) {
    stands_off = std::max({stands_off, EdgeFilaments(t, seed_, from_edge, y_m),
                           DetachedBundle(options_, seed_, from_edge, y_m)});
  }
  MatPoint point{height + stands_off, weave.strength * SlopeStrength(mould.slope)};
  for (const MatOptions::Obstacle& obstacle : options_.obstacles) {
    const double rises = ObstacleHeight(obstacle, x_m, y_m);
    if (rises > 0.0) point = {std::max(point.height_m, height + rises), 1.0};
  }
  return point;
}

}  // namespace rangegrasp::stitching
