#include "seam/stitching/mats.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/rng.h"
#include "base/units.h"
#include "seam/stitching/internal/mat_texture.h"

namespace rangegrasp::seam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Shape of a frayed edge: a part that varies this much faster, and its strength relative to the
// slow part.
constexpr double kFastFrayRate = 3.0;
constexpr double kFastFray = 0.5;
// An obstacle's border rises over this width, which belongs to its footprint, or over this share of
// its size if that is less.
constexpr double kObstacleBorder_m = 0.2e-3;
constexpr double kObstacleBorderShare = 0.25;
// An obstacle is not a fibre and returns light well.
constexpr double kObstacleReturn = 0.9;
// A filament of at least this share of the full height hides the mat below it.
constexpr double kHidingShare = 0.25;
// Filaments on a black mat return this much less light than on a bright one.
constexpr double kFilamentDarkness = 0.9;

// Share of the upper mat's height, and share of its texture in what is visible.
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

// ---- random seams and hazards ----

// Heights of the upper mat (dissertation, section 1.1.1: "between 0.3mm and 1.1mm").
constexpr double kMinHeight_m = 0.3e-3;
constexpr double kMaxHeight_m = 1.1e-3;
// Lower slants and double edges would not be edges: a slant spreads its height over millimetres, a
// double edge splits it.
constexpr double kMinSoftHeight_m = 0.5e-3;

// Ranges of a seam's other properties, about the defaults of MatOptions.
constexpr Range kEdgeWidth_m = {0.05e-3, 0.25e-3};
constexpr Range kSlantWidth_m = {1.6e-3, 2.4e-3};  // about 2 mm (section 3.6.2)
constexpr Range kDoubleGap_m = {1.5e-3, 3e-3};
constexpr Range kDoubleShare = {0.2, 0.35};
constexpr Range kTilt_rad = {-0.05, 0.05};
// A recorded seam's distance from the top of its mould [radii].
constexpr Range kBesideTop = {-0.1, 0.1};

// Half of the middle 60 % of a line of 57 mm.
constexpr double kStraightOffset_m = 0.3 * 57e-3;
// A recorded seam is nearly parallel to the sensor's motion, as if the sensor were moved by hand.
// With a larger slope, its edge would leave the line before the recording ends.
constexpr double kStraightSlope = 0.04;

// Start of a curved seam.
constexpr double kCurvedOffset_m = 3e-3;
// Maximum slope of a curved seam: within 26 degrees of the track, which the head can follow.
constexpr double kMaxSlope = 0.48;
// Deviation of a curved seam from the track: "the seam deviation can be several centimetres"
// (section 3.6.2).
constexpr double kMinDeviation_m = 10e-3;
constexpr double kMaxDeviation_m = 30e-3;
constexpr double kMouldDeviation = 0.2;  // of its radius: further down a mould the edge is lost
// Length over which a deviation is measured, and its sampling: the shortest wave is 80 mm long.
constexpr double kCourse_m = 0.5;
constexpr double kCourseSpacing_m = 2e-3;
// On a mould, where seams deviate less, the start offset is below this share of the deviation.
constexpr double kStartShare = 0.1;
// A long wave makes the deviation; shorter waves on it take a share of the remaining slope.
constexpr Range kLongWave_m = {0.25, 0.4};
constexpr Range kLongSlope = {0.28, 0.42};
constexpr Range kShortWave_m = {0.08, 0.25};
constexpr Range kShortShare = {0.2, 0.8};

// A hazard lies this far along the track: the loop has settled (closed_loop.h, kSettle_m) and most
// of a track of 400 mm is still ahead.
constexpr Range kHazard_m = {0.15, 0.25};
// Offset from the needle's path: the widest obstacle still reaches the path.
constexpr Range kObstacleBeside_m = {-0.01, 0.01};
// Footprint and height: from the smallest that the monitor must find, 3 mm high (section 3.7), to
// one that no head could miss.
constexpr Range kObstacleSize_m = {0.001, 0.02};
constexpr Range kObstacleHeight_m = {0.003, 0.02};

// One long wave and one or two shorter ones.
std::vector<EdgeCourse::Wave> RandomWaves(base::Rng& rng) {
  std::vector<EdgeCourse::Wave> waves(2 + rng.Index(2));
  double slope_left = kMaxSlope;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    EdgeCourse::Wave& wave = waves[i];
    wave.length_m = (i == 0 ? kLongWave_m : kShortWave_m).Draw(rng);
    const double slope = i == 0 ? kLongSlope.Draw(rng) : kShortShare.Draw(rng) * slope_left;
    slope_left -= slope;
    wave.amplitude_m = slope * wave.length_m / (2.0 * base::kPi);
    wave.phase_rad = rng.Uniform(0.0, 2.0 * base::kPi);
  }
  return waves;
}

double MaxDeviation(const EdgeCourse& course) {
  double max = 0.0;
  for (double y = 0.0; y <= kCourse_m; y += kCourseSpacing_m) {
    max = std::max(max, std::abs(course.XAt(y)));
  }
  return max;
}

// Starts near the planned track and deviates by the drawn amount, or as far as its slope allows.
EdgeCourse CurvedCourse(double max_m, base::Rng& rng) {
  EdgeCourse course;
  course.waves = RandomWaves(rng);
  const double start = rng.Uniform(-kCurvedOffset_m, kCurvedOffset_m);
  const double wanted = rng.Uniform(std::min(kMinDeviation_m, max_m), max_m);
  course.offset_m = -course.XAt(0.0);
  double slope = 0.0;
  for (const auto& wave : course.waves) slope += 2.0 * base::kPi * wave.amplitude_m / wave.length_m;
  course.Scale(std::min(wanted / MaxDeviation(course), kMaxSlope / slope));
  course.offset_m += std::min(1.0, kStartShare * max_m / kCurvedOffset_m) * start;
  return course;
}

EdgeCourse StraightCourse(base::Rng& rng) {
  EdgeCourse course;
  course.offset_m = rng.Uniform(-kStraightOffset_m, kStraightOffset_m);
  course.slope = rng.Uniform(-kStraightSlope, kStraightSlope);
  return course;
}

// Fine or coarse, dull or glossy, dark or bright, well or badly cut: each value varies around the
// typical one by up to a factor. With larger factors, rates differ more between seams.
MatTexture RandomTexture(const MatTexture& typical, base::Rng& rng) {
  using T = MatTexture;
  T texture = typical;
  texture.weave = static_cast<Weave>(rng.Index(3));
  for (const auto& [member, factor] :
       {std::pair{&T::weave_period_m, 2.0}, std::pair{&T::weave_relief_m, 1.6},
        std::pair{&T::fuzz_m, 1.5}, std::pair{&T::waviness_m, 1.5},
        std::pair{&T::waviness_length_m, 1.5}, std::pair{&T::fray_m, 1.7},
        std::pair{&T::fray_length_m, 1.5}, std::pair{&T::filaments_per_m, 2.0},
        std::pair{&T::loose_filaments_per_m2, 2.0}, std::pair{&T::filament_height_m, 1.4},
        std::pair{&T::detached_share, 2.0}, std::pair{&T::gloss, 1.7},
        std::pair{&T::darkness, 1.4}}) {
    texture.*member *= std::pow(factor, rng.Uniform(-1.0, 1.0));
  }
  for (const auto share : {&T::detached_share, &T::gloss, &T::darkness}) {
    texture.*share = std::min(texture.*share, 1.0);
  }
  return texture;
}

}  // namespace

void EdgeCourse::Scale(double factor) {
  offset_m *= factor;
  for (Wave& wave : waves) wave.amplitude_m *= factor;
}

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
        fray_scale_m(o.texture.fray_m / std::sqrt((1.0 + kFastFray * kFastFray) * kNoiseVariance)),
        has_upper(o.shape != EdgeShape::kNone),
        tan_tilt(std::tan(o.tilt_rad)) {}

  double Edge(double y_m) const {
    const double t = y_m / options.texture.fray_length_m;
    return options.course.XAt(y_m) +
           fray_scale_m *
               (Noise(fray_seed, t) + kFastFray * Noise(fast_fray_seed, kFastFrayRate * t));
  }

  // Share of the upper mat: 0 beyond its end, which is cut no better than its edge.
  double Presence(double x_m, double y_m) const {
    const double margin = fray_scale_m + options.edge_width_m;  // noise stays within [-1, 1]
    if (y_m < options.end_y_m - margin) return 1.0;
    const double end =
        options.end_y_m + fray_scale_m * Noise(end_seed, x_m / options.texture.fray_length_m);
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
    // Filaments are as dark as the mats; below the full height, the mat between them is visible.
    const double cover =
        Ramp(filament.height_m / (kHidingShare * options.texture.filament_height_m));
    const double strength =
        filament.return_strength * (1.0 - kFilamentDarkness * options.texture.darkness);
    point.return_strength = Mix(point.return_strength, strength, cover * presence);
  }

  // A mould is a cylinder up to a slope of 45 degrees, then straight on.
  void AddMould(double x_m, MatPoint& point) const {
    double height_m = 0.0;
    double slope_rad = 0.0;
    if (options.shape == EdgeShape::kConvex || options.shape == EdgeShape::kConcave) {
      const double r = options.radius_m;
      const double half_m = r * std::sqrt(0.5);
      const double x = std::abs(x_m - options.mould_x_m);
      const double on_arc = std::min(x, half_m);
      const double sign = options.shape == EdgeShape::kConvex ? -1.0 : 1.0;
      height_m = sign * (r - std::sqrt(r * r - on_arc * on_arc) + (x - on_arc));
      slope_rad = std::copysign(x < half_m ? std::asin(x / r) : 0.25 * base::kPi,
                                sign * (x_m - options.mould_x_m));
    }
    point.height_m += height_m + tan_tilt * x_m;
    const double slope = std::abs(slope_rad + options.tilt_rad);
    point.return_strength *= 1.0 - Ramp(2.0 * slope / options.texture.steep_rad - 1.0);
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
  Tows low, high;
  Filaments filaments;
  std::uint64_t fray_seed, fast_fray_seed, end_seed;
  double fray_scale_m;
  bool has_upper;
  double tan_tilt;
};

Mats::Mats(const MatOptions& options, std::uint64_t seed)
    : impl_(std::make_shared<const Impl>(options, seed)) {}

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

MatOptions RandomMats(EdgeShape shape, const MatTexture& typical, bool curved, std::uint64_t seed) {
  base::Rng rng(base::DeriveSeed(seed, "random mats"));
  const bool soft = shape == EdgeShape::kSlant || shape == EdgeShape::kDouble;
  const bool mould = shape == EdgeShape::kConvex || shape == EdgeShape::kConcave;
  MatOptions options;
  options.shape = shape;
  options.height_m = rng.Uniform(soft ? kMinSoftHeight_m : kMinHeight_m, kMaxHeight_m);
  options.edge_width_m = kEdgeWidth_m.Draw(rng);
  options.slant_width_m = kSlantWidth_m.Draw(rng);
  options.double_gap_m = kDoubleGap_m.Draw(rng);
  options.double_share = kDoubleShare.Draw(rng);
  options.tilt_rad = kTilt_rad.Draw(rng);
  const double beside_top = kBesideTop.Draw(rng) * options.radius_m;
  options.texture = RandomTexture(typical, rng);
  if (curved) {
    const double max = mould ? kMouldDeviation * options.radius_m : kMaxDeviation_m;
    options.course = CurvedCourse(max, rng);
  } else {
    options.course = StraightCourse(rng);
    options.mould_x_m = options.course.offset_m + beside_top;
  }
  return options;
}

void AddRandomHazard(MatOptions& mats, double wanted_distance_m, std::uint64_t seed) {
  base::Rng rng(seed);
  const double y = kHazard_m.Draw(rng);
  if (rng.Uniform() < 0.5) {
    mats.end_y_m = y;
    return;
  }
  MatOptions::Obstacle obstacle;
  obstacle.y_m = y;
  obstacle.x_m = mats.course.XAt(y) - wanted_distance_m + kObstacleBeside_m.Draw(rng);
  obstacle.size_x_m = kObstacleSize_m.Draw(rng);
  obstacle.size_y_m = kObstacleSize_m.Draw(rng);
  obstacle.height_m = kObstacleHeight_m.Draw(rng);
  mats.obstacles.push_back(obstacle);
}

}  // namespace rangegrasp::seam
