#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/rng.h"
#include "seam/stitching/mats.h"

namespace rangegrasp::seam {

/// 64 well-mixed bits of a lattice cell.
inline std::uint64_t Hash(std::uint64_t seed, std::int64_t i, std::int64_t j = 0) {
  std::uint64_t h = seed ^ (static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15u);
  h ^= (static_cast<std::uint64_t>(j) + 0x632BE59BD9B4E019u) * 0xC2B2AE3D27D4EB4Fu;
  h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93u;
  h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9u;
  return h ^ (h >> 32);
}

/// Four independent values in [0, 1) of one hash: field 0 .. 3.
inline double Unit(std::uint64_t hash, int field) {
  return static_cast<double>((hash >> (16 * field)) & 0xFFFFu) * 0x1.0p-16;
}

/// 0 up to t = 0, 1 from t = 1, with a smooth rise in between.
inline double Ramp(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

inline double Mix(double a, double b, double t) { return a + (b - a) * t; }

/// Range of a property.
struct Range {
  double low, high;
  double At(double t) const { return Mix(low, high, t); }
  double Draw(base::Rng& rng) const { return rng.Uniform(low, high); }
};

/// A number split into its cell and the position in it, [0, 1).
struct Cell {
  explicit Cell(double t) {
    const double floor = std::floor(t);
    index = static_cast<std::int64_t>(floor);
    rest = t - floor;
  }
  std::int64_t index;
  double rest;
};

/// Smooth noise in [-1, 1] over cells of length 1: uniform values at lattice points, interpolated.
inline double Noise(std::uint64_t seed, double t) {
  const Cell cell(t);
  const double a = Unit(Hash(seed, cell.index), 0);
  const double b = Unit(Hash(seed, cell.index + 1), 0);
  return 2.0 * Mix(a, b, Ramp(cell.rest)) - 1.0;
}

inline double Noise(std::uint64_t seed, double u, double v) {
  const Cell i(u);
  const Cell j(v);
  const double along = Ramp(i.rest);
  const double low =
      Mix(Unit(Hash(seed, i.index, j.index), 0), Unit(Hash(seed, i.index + 1, j.index), 0), along);
  const double high = Mix(Unit(Hash(seed, i.index, j.index + 1), 0),
                          Unit(Hash(seed, i.index + 1, j.index + 1), 0), along);
  return 2.0 * Mix(low, high, Ramp(j.rest)) - 1.0;
}

/// Variance of Noise(t): 1/3 of a uniform value, times the mean of (1 - r)^2 + r^2 over the ramp r,
/// 26/35. In two dimensions this factor applies twice.
constexpr double kNoiseVariance = 26.0 / 105.0;
constexpr double kPlaneNoiseVariance = kNoiseVariance * 26.0 / 35.0;

/// The surface of one mat relative to its mean height: crossing tows of fibres and their fuzz.
class Tows {
 public:
  Tows(const MatTexture& texture, std::uint64_t seed);
  MatPoint At(double x_m, double y_m) const;

 private:
  // The tow on top: position across it and along its visible part, and position on the tow.
  struct Top {
    double across, along;  // 0 .. 1
    std::int64_t tow;
    double position;  // along the tow, in tow widths
    double away;      // share of this direction that reflects light away
    std::uint64_t seed;
  };
  Top TopAt(double p, double q) const;
  double AwayAt(const Top& top) const;

  Weave weave_;
  std::uint64_t warp_seed_, weft_seed_, fuzz_seed_, wave_seed_;
  double px_, py_, qx_, qy_;  // p and q count tow widths across weft and warp
  double warp_away_, weft_away_;
  double relief_m_, fuzz_m_, fuzz_per_m_, wave_m_, waves_per_m_;
  double brightness_;
};

/// Fibres that stick out of the mats: filaments near the edge and elsewhere, and bundles that are
/// detached from the edge. Each is a thin ridge.
class Filaments {
 public:
  Filaments(const MatTexture& texture, double edge_height_m, std::uint64_t seed);
  /// The highest ridge above the surface at (x, y), where the edge is at x - across.
  /// return_strength is valid only for a height above 0.
  MatPoint NearEdge(double across_m, double y_m) const;
  MatPoint Elsewhere(double x_m, double y_m) const;

 private:
  void Detached(double across_m, double y_m, MatPoint& highest) const;

  std::uint64_t edge_seed_, loose_seed_, detached_seed_;
  double per_edge_cell_, per_loose_cell_;
  double height_m_, reach_m_, edge_height_m_;
  double detached_share_;
};

}  // namespace rangegrasp::seam
