#include "seam/stitching/random_mats.h"

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::stitching {
namespace {

// Heights of the upper mat (dissertation, section 1.1.1: "between 0.3mm and 1.1mm").
constexpr double kMinHeight_m = 0.3e-3;
constexpr double kMaxHeight_m = 1.1e-3;
// Lower ones would not be edges any more: a slant spreads its height over millimetres, a double
// edge gives a share of it away.
constexpr double kMinSoftHeight_m = 0.5e-3;

// Ranges of a seam's other properties, about the defaults of MatOptions.
struct Range {
  double low, high;
  double Draw(base::Rng& rng) const { return rng.Uniform(low, high); }
};
constexpr Range kEdgeWidth_m = {0.05e-3, 0.25e-3};
constexpr Range kSlantWidth_m = {1.6e-3, 2.4e-3};  // about 2 mm (section 3.6.2)
constexpr Range kDoubleGap_m = {1.5e-3, 3e-3};
constexpr Range kDoubleShare = {0.2, 0.35};
constexpr Range kTilt_rad = {-0.05, 0.05};
// A recorded seam's distance from the top of its mould [radii].
constexpr Range kBesideTop = {-0.1, 0.1};

// Half of the middle 60 % of a line of 57 mm.
constexpr double kStraightOffset_m = 0.3 * 57e-3;
// A recorded seam runs nearly along the sensor's way, as where one moves a sensor by hand: steeper,
// and its edge would leave the line before the recording ends.
constexpr double kStraightSlope = 0.04;

// Of curved seams: where one starts, ...
constexpr double kCurvedOffset_m = 3e-3;
// ... how steep it may be: within 26 degrees of the track, which the head can follow, ...
constexpr double kMaxSlope = 0.48;
// ... and how far it leaves the track: "the seam deviation can be several centimetres" (section
// 3.6.2).
constexpr double kMinDeviation_m = 10e-3;
constexpr double kMaxDeviation_m = 30e-3;
constexpr double kMouldDeviation = 0.2;  // of its radius: further down a mould the edge is lost
// Over which a deviation is measured, and how densely: the shortest wave is 80 mm long.
constexpr double kCourse_m = 0.5;
constexpr double kCourseSpacing_m = 2e-3;
// On a mould, where seams deviate less, a seam starts off by less than this share of the deviation.
constexpr double kStartShare = 0.1;
// A long wave that makes the deviation, and shorter ones on it that take a share of the slope left.
constexpr Range kLongWave_m = {0.25, 0.4};
constexpr Range kLongSlope = {0.28, 0.42};
constexpr Range kShortWave_m = {0.08, 0.25};
constexpr Range kShortShare = {0.2, 0.8};

// A hazard lies this far along the track: the loop has settled (closed_loop.h, kSettle_m) and most
// of a track of 400 mm is still ahead.
constexpr double kHazardBegin_m = 0.15;
constexpr double kHazardEnd_m = 0.25;
// Beside the needle's path at most: the widest obstacle then still reaches it.
constexpr double kObstacleBeside_m = 0.01;
// Footprint and height: from the smallest that the monitor must find, 3 mm high (section 3.7), to
// what no head could miss.
constexpr double kObstacleMinSize_m = 0.001;
constexpr double kObstacleMaxSize_m = 0.02;
constexpr double kObstacleMinHeight_m = 0.003;
constexpr double kObstacleMaxHeight_m = 0.02;

double SlopeOf(const EdgeCourse::Wave& wave) {
  return 2.0 * base::kPi * wave.amplitude_m / wave.length_m;
}

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

void Scale(EdgeCourse& course, double factor) {
  course.offset_m *= factor;
  for (EdgeCourse::Wave& wave : course.waves) wave.amplitude_m *= factor;
}

// Starts near the planned track and deviates as far as asked, or as far as its slope allows.
EdgeCourse CurvedCourse(double max_m, base::Rng& rng) {
  EdgeCourse course;
  course.waves = RandomWaves(rng);
  const double start = rng.Uniform(-kCurvedOffset_m, kCurvedOffset_m);
  const double wanted = rng.Uniform(std::min(kMinDeviation_m, max_m), max_m);
  course.offset_m = -course.XAt(0.0);
  double slope = 0.0;
  for (const EdgeCourse::Wave& wave : course.waves) slope += SlopeOf(wave);
  Scale(course, std::min(wanted / MaxDeviation(course), kMaxSlope / slope));
  course.offset_m += std::min(1.0, kStartShare * max_m / kCurvedOffset_m) * start;
  return course;
}

EdgeCourse StraightCourse(base::Rng& rng) {
  EdgeCourse course;
  course.offset_m = rng.Uniform(-kStraightOffset_m, kStraightOffset_m);
  course.slope = rng.Uniform(-kStraightSlope, kStraightSlope);
  return course;
}

// Fine or coarse, dull or glossy, dark or bright, well or badly cut: each about what is typical, up
// to a factor. Larger factors make seams differ more in their rates.
MatTexture RandomTexture(const MatTexture& typical, base::Rng& rng) {
  MatTexture texture = typical;
  const auto scale = [&](double& value, double factor) {
    value *= std::pow(factor, rng.Uniform(-1.0, 1.0));
  };
  texture.weave = static_cast<Weave>(rng.Index(3));
  scale(texture.weave_period_m, 2.0);
  scale(texture.weave_relief_m, 1.6);
  scale(texture.fuzz_m, 1.5);
  scale(texture.waviness_m, 1.5);
  scale(texture.waviness_length_m, 1.5);
  scale(texture.fray_m, 1.7);
  scale(texture.fray_length_m, 1.5);
  scale(texture.filaments_per_m, 2.0);
  scale(texture.loose_filaments_per_m2, 2.0);
  scale(texture.filament_height_m, 1.4);
  scale(texture.detached_share, 2.0);
  scale(texture.gloss, 1.7);
  scale(texture.darkness, 1.4);
  texture.detached_share = std::min(texture.detached_share, 1.0);
  texture.gloss = std::min(texture.gloss, 1.0);
  texture.darkness = std::min(texture.darkness, 1.0);
  return texture;
}

}  // namespace

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
  const double y = rng.Uniform(kHazardBegin_m, kHazardEnd_m);
  if (rng.Uniform() < 0.5) {
    mats.end_y_m = y;
    return;
  }
  MatOptions::Obstacle obstacle;
  obstacle.y_m = y;
  obstacle.x_m =
      mats.course.XAt(y) - wanted_distance_m + rng.Uniform(-kObstacleBeside_m, kObstacleBeside_m);
  obstacle.size_x_m = rng.Uniform(kObstacleMinSize_m, kObstacleMaxSize_m);
  obstacle.size_y_m = rng.Uniform(kObstacleMinSize_m, kObstacleMaxSize_m);
  obstacle.height_m = rng.Uniform(kObstacleMinHeight_m, kObstacleMaxHeight_m);
  mats.obstacles.push_back(obstacle);
}

}  // namespace rangegrasp::stitching
