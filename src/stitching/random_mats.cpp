#include <algorithm>
#include <numbers>

#include "stitching/mats.h"

namespace rangegrasp::stitching {
namespace {

constexpr double kLowest_m = 0.3e-3;  // the dissertation's mats (sections 3.1, 3.5.3)
constexpr double kHighest_m = 1.1e-3;
constexpr double kLowestSlant_m = 0.5e-3;  // a lower one over 2 mm is no step of the minimal size
constexpr double kSteepest = 0.5;          // slope of a curved edge against the track

MatTexture VaryTexture(const MatTexture& typical, core::Rng& rng) {
  MatTexture t = typical;
  t.weave_period_m *= rng.Uniform(0.7, 1.8);
  t.weave_relief_m *= rng.Uniform(0.5, 1.5);
  t.fuzz_m *= rng.Uniform(0.5, 1.5);
  t.fray_m *= rng.Uniform(0.5, 1.5);
  t.filaments_per_m *= rng.Uniform(0.3, 1.7);
  t.loose_filaments_per_m2 *= rng.Uniform(0.3, 1.7);
  t.filament_height_m *= rng.Uniform(0.6, 1.4);
  t.detached_share = std::min(1.0, t.detached_share * rng.Uniform(0.0, 2.0));
  t.gloss = std::min(1.0, t.gloss * rng.Uniform(0.4, 1.6));
  t.darkness = std::min(1.0, t.darkness * rng.Uniform(0.6, 1.4));
  return t;
}

// Two or three waves of 80 to 400 mm whose slopes together stay below kSteepest.
EdgeCourse CurvedCourse(core::Rng& rng) {
  EdgeCourse course;
  const std::size_t count = 2 + rng.Index(2);
  for (std::size_t i = 0; i < count; ++i) {
    EdgeCourse::Wave wave{};
    wave.length_m = rng.Uniform(0.08, 0.4);
    const double steep = kSteepest / static_cast<double>(count) * rng.Uniform(0.3, 1.0);
    wave.amplitude_m = std::min(0.015, steep * wave.length_m / (2.0 * std::numbers::pi));
    wave.phase_rad = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    course.waves.push_back(wave);
  }
  course.offset_m = rng.Uniform(-0.005, 0.005);
  return course;
}

}  // namespace

MatOptions RandomMats(EdgeShape shape, const MatTexture& typical, bool curved, std::uint64_t seed) {
  core::Rng rng(core::DeriveSeed(seed, "mats"));
  MatOptions options;
  options.shape = shape;
  options.height_m =
      rng.Uniform(shape == EdgeShape::kSlant ? kLowestSlant_m : kLowest_m, kHighest_m);
  options.edge_width_m = rng.Uniform(0.05e-3, 0.25e-3);
  options.slant_width_m = rng.Uniform(1.6e-3, 2.4e-3);
  options.double_gap_m = rng.Uniform(1e-3, 3e-3);
  options.double_share = rng.Uniform(0.15, 0.4);
  options.tilt_rad = rng.Uniform(-0.05, 0.05);
  options.texture = VaryTexture(typical, rng);
  if (curved) {
    options.course = CurvedCourse(rng);
  } else {
    options.course.offset_m = rng.Uniform(-0.017, 0.017);
    options.course.slope = rng.Uniform(-0.03, 0.03);
  }
  return options;
}

}  // namespace rangegrasp::stitching
