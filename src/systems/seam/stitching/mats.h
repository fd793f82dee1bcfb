#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace rangegrasp::seam {

/// The kinds of edge of figure 3.15.
enum class EdgeShape { kStep, kDouble, kSlant, kConvex, kConcave, kNone };
constexpr std::array<std::string_view, 6> WordsOf(EdgeShape) {
  return {"step", "double", "slant", "convex", "concave", "none"};
}

/// Course of the upper mat's edge: x = offset + waves(y) + bump(y). Frame M of the mats: y along
/// the track that CAD planned (x = 0), x across, z up, [m].
struct EdgeCourse {
  double offset_m = 0.0;
  double slope = 0.0;  ///< of a straight course
  struct Wave {
    double amplitude_m;
    double length_m;  ///< > 0
    double phase_rad;
  };
  std::vector<Wave> waves;            ///< a curved seam; a mat that was draped carelessly
  double half_circle_radius_m = 0.0;  ///< > 0: a half circle (fig. 3.25) on the low side
  double half_circle_y_m = 0.0;       ///< y of its middle

  double XAt(double y_m) const;
  /// Scales offset and waves.
  void Scale(double factor);
};

/// Arrangement of the tows in a mat (dissertation, section 3.1.1).
enum class Weave {
  kUniDirectional,  ///< parallel tows, held by bright thin threads across them
  kWoven,           ///< two directions at right angles, over one and under one
  kPlaited,         ///< two slanted directions, over two and under two
};

/// Appearance of the mats: the keys of `texture` in an experiment describe most values. The
/// defaults are the frozen settings (docs/seam.md).
struct MatTexture {
  double weave_period_m = 3e-3;  ///< width of a tow
  double weave_relief_m = 0.0114e-3;
  double fuzz_m = 0.0055e-3;
  double waviness_m = 0.12e-3;  ///< mats are "very uneven" (section 3.7)
  double waviness_length_m = 0.5e-3;
  double fray_m = 0.11e-3;
  double fray_length_m = 4e-3;  ///< correlation length of the edge's deviation
  double filaments_per_m = 70.0;
  double loose_filaments_per_m2 = 250.0;
  double filament_height_m = 0.33e-3;
  double detached_share = 0.005;
  double gloss = 0.055;
  double darkness = 0.5;
  Weave weave = Weave::kWoven;
  double fuzz_length_m = 0.3e-3;   ///< length of fuzz along x; three times this along y
  double filament_reach_m = 2e-3;  ///< mean distance of the edge's filaments from the edge
  double steep_rad = 0.4;          ///< no light returns from this slope on, less from half of it on
};

struct MatOptions {
  EdgeShape shape = EdgeShape::kStep;
  double height_m = 0.6e-3;      ///< of the upper mat; the dissertation's mats: 0.3 to 1.1 mm
  double edge_width_m = 0.1e-3;  ///< width over which a step rises
  double slant_width_m = 2e-3;   ///< (section 3.6.2)
  double double_gap_m = 2e-3;    ///< between the two steps of a double edge
  double double_share = 0.3;     ///< share of the height in the minor step
  double radius_m = 0.03;        ///< of a mould's cylinder (section 3.6.3)
  double mould_x_m = 0.0;        ///< of its axis
  double tilt_rad = 0.0;         ///< of the surface across the seam
  EdgeCourse course;
  MatTexture texture;
  double end_y_m = 1e9;  ///< end of the upper mat: no edge beyond
  struct Obstacle {
    double x_m, y_m, size_x_m, size_y_m, height_m;
  };
  std::vector<Obstacle> obstacles;
};

/// Surface point that a laser spot hits.
struct MatPoint {
  double height_m;
  double return_strength;  ///< 0 (no light returns) .. 1
};

/// Overlapping carbon-fibre mats: a deterministic surface z(x, y), with its ground truth.
class Mats {
 public:
  Mats(const MatOptions& options, std::uint64_t seed);
  MatPoint At(double x_m, double y_m) const;
  /// The labelled edge at y, with its fray: the middle of a step or slant, the major step of a
  /// double edge. NaN with shape kNone and beyond the mat's end.
  double EdgeX(double y_m) const;
  const MatOptions& options() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;  ///< copies share it
};

/// A random seam like those in production: height 0.3 to 1.1 mm, course, texture around `typical`,
/// tilt.
MatOptions RandomMats(EdgeShape shape, const MatTexture& typical, bool curved, std::uint64_t seed);

/// Adds a hazard 150 to 250 mm along the track, where the loop has settled: with equal probability
/// the mats end, or an obstacle lies within 10 mm of the needle's path.
/// @param wanted_distance_m  of the needle from the edge, on its low side.
void AddRandomHazard(MatOptions& mats, double wanted_distance_m, std::uint64_t seed);

}  // namespace rangegrasp::seam
