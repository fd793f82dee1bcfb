#include <algorithm>
#include <cmath>

#include "core/rng.h"
#include "core/units.h"
#include "stitching/mats.h"

namespace rangegrasp::stitching {
namespace {

constexpr double kLowest_m = 0.3e-3;
constexpr double kHighest_m = 1.1e-3;
// Lower ones would not be edges any more: a slant spreads its height over millimetres, a double
// edge gives a share of it away.
constexpr double kLowestSoft_m = 0.5e-3;

// Half of the middle 60 % of a line of 57 mm.
constexpr double kStraightOffset_m = 0.3 * 57e-3;
constexpr double kStraightSlope = 0.04;

constexpr double kCurvedOffset_m = 3e-3;  // where a curved seam starts
constexpr double kSteepestCourse = 0.48;
constexpr double kSmallestDeviation_m = 10e-3;
constexpr double kLargestDeviation_m = 30e-3;
constexpr double kMouldDeviation = 0.2;  // of its radius: further down a mould the edge is lost
constexpr double kCourse_m = 0.5;        // over which a deviation is measured

double SlopeOf(const EdgeCourse::Wave& wave) {
  return 2.0 * core::kPi * wave.amplitude_m / wave.length_m;
}

// A long wave that makes the deviation, and one or two shorter ones on it.
std::vector<EdgeCourse::Wave> RandomWaves(core::Rng& rng) {
  std::vector<EdgeCourse::Wave> waves(2 + rng.Index(2));
  double slope_left = kSteepestCourse;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    EdgeCourse::Wave& wave = waves[i];
    wave.length_m = i == 0 ? rng.Uniform(0.25, 0.4) : rng.Uniform(0.08, 0.25);
    const double slope = i == 0 ? rng.Uniform(0.28, 0.42) : rng.Uniform(0.2, 0.8) * slope_left;
    slope_left -= slope;
    wave.amplitude_m = slope * wave.length_m / (2.0 * core::kPi);
    wave.phase_rad = rng.Uniform(0.0, 2.0 * core::kPi);
  }
  return waves;
}

double LargestDeviation(const EdgeCourse& course) {
  double largest = 0.0;
  for (double y = 0.0; y <= kCourse_m; y += 2e-3) {
    largest = std::max(largest, std::abs(course.XAt(y)));
  }
  return largest;
}

void Scale(EdgeCourse& course, double factor) {
  course.offset_m *= factor;
  for (EdgeCourse::Wave& wave : course.waves) wave.amplitude_m *= factor;
}

// Starts near the planned track and deviates as far as asked, or as far as its slope allows.
EdgeCourse CurvedCourse(double largest_m, core::Rng& rng) {
  EdgeCourse course;
  course.waves = RandomWaves(rng);
  const double start = rng.Uniform(-kCurvedOffset_m, kCurvedOffset_m);
  const double wanted = rng.Uniform(std::min(kSmallestDeviation_m, largest_m), largest_m);
  course.offset_m = -course.XAt(0.0);
  double slope = 0.0;
  for (const EdgeCourse::Wave& wave : course.waves) slope += SlopeOf(wave);
  Scale(course, std::min(wanted / LargestDeviation(course), kSteepestCourse / slope));
  course.offset_m += std::min(1.0, 0.1 * largest_m / kCurvedOffset_m) * start;
  return course;
}

EdgeCourse StraightCourse(core::Rng& rng) {
  EdgeCourse course;
  course.offset_m = rng.Uniform(-kStraightOffset_m, kStraightOffset_m);
  course.slope = rng.Uniform(-kStraightSlope, kStraightSlope);
  return course;
}

// Fine or coarse, dull or glossy, dark or bright, well or badly cut: each round what is typical.
MatTexture RandomTexture(const MatTexture& typical, core::Rng& rng) {
  MatTexture texture = typical;
  const auto scale = [&](double& value, double factor) {
    value *= std::pow(factor, rng.Uniform(-1.0, 1.0));
  };
  texture.weave = static_cast<Weave>(rng.Index(3));
  scale(texture.weave_period_m, 2.0);
  scale(texture.weave_relief_m, 1.6);
  scale(texture.fuzz_m, 1.5);
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
  core::Rng rng(core::DeriveSeed(seed, "random mats"));
  const bool soft = shape == EdgeShape::kSlant || shape == EdgeShape::kDouble;
  const bool mould = shape == EdgeShape::kConvex || shape == EdgeShape::kConcave;
  MatOptions options;
  options.shape = shape;
  options.height_m = rng.Uniform(soft ? kLowestSoft_m : kLowest_m, kHighest_m);
  options.edge_width_m = rng.Uniform(0.05e-3, 0.25e-3);
  options.slant_width_m = rng.Uniform(1.6e-3, 2.4e-3);
  options.double_gap_m = rng.Uniform(1.5e-3, 3e-3);
  options.double_share = rng.Uniform(0.2, 0.35);
  options.tilt_rad = rng.Uniform(-0.05, 0.05);
  const double beside_top = rng.Uniform(-0.1, 0.1) * options.radius_m;
  options.texture = RandomTexture(typical, rng);
  if (curved) {
    const double largest = mould ? kMouldDeviation * options.radius_m : kLargestDeviation_m;
    options.course = CurvedCourse(largest, rng);
  } else {
    options.course = StraightCourse(rng);
    options.mould_x_m = options.course.offset_m + beside_top;
  }
  return options;
}

}  // namespace rangegrasp::stitching
