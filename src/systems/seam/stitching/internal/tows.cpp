#include "seam/stitching/internal/tows.h"

#include <array>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"
#include "seam/stitching/internal/lattice_noise.h"

namespace rangegrasp::stitching::internal {
namespace {

// Section 3.1.1 describes the mats and gives no figures: these only shape them. What the rates
// depend on most are options of MatTexture that a fit chose.
//
// A black mat still returns this much: ten times the loss threshold of the base sensor.
constexpr double kBlackReturn = 0.1;
// What comes back from a stretch of tow that sends the light elsewhere: between the loss thresholds
// of the two sensors (0.01 and 0.1), so that the one sees it and the other does not.
constexpr double kAwayReturn = 0.06;
// Stretches of one look are about this long [tow widths].
constexpr double kStretch = 3.0;
// Threads that hold a uni-directional mat together: spacing and width [tow widths], and how far
// they stand off it [reliefs].
constexpr double kThreadSpacing = 2.5;
constexpr double kThreadWidth = 0.12;
constexpr double kThreadHeight = 0.5;
// By which a fabric lies off its direction [rad], and half the angle between plaited tows.
constexpr double kMaxAngleError_rad = 0.1;
constexpr double kMinPlaitHalf_rad = 0.5;
constexpr double kMaxPlaitHalf_rad = 0.8;
// Share of a glossy tow that sends the light elsewhere: of one that runs along x, and by how much
// more of one that runs along y.
constexpr double kAwayAlongX = 0.25;
constexpr double kAwayMoreAlongY = 0.5;
// Fuzz varies this much more slowly along y, as fibres do.
constexpr double kFuzzStretch = 3.0;
// Mean of the relief's shape, so that a mat's mean height is 0.
constexpr double kMeanRelief = 0.8 * 2.0 / 3.0;  // of AcrossShape times AlongShape
constexpr double kMeanRidge = 0.8;               // of AcrossShape

// A tow is flat on top with steep sides; along its visible part it bends more gently.
double AcrossShape(double t) {
  const double u = (2.0 * t - 1.0) * (2.0 * t - 1.0);
  return 1.0 - u * u;
}
double AlongShape(double t) { return 1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0); }

// Angles of p and q against x. A fabric is laid with its tows along, across or at 45 degrees, with
// a few degrees of error.
std::array<double, 2> TowAngles(Weave weave, std::uint64_t seed) {
  base::Rng rng(base::DeriveSeed(seed, "angle"));
  const double error = rng.Uniform(-kMaxAngleError_rad, kMaxAngleError_rad);
  const double turn = 0.25 * base::kPi * static_cast<double>(rng.Index(4)) + error;
  if (weave != Weave::kPlaited) return {turn, turn + 0.5 * base::kPi};
  const double half = rng.Uniform(kMinPlaitHalf_rad, kMaxPlaitHalf_rad);
  return {error + half, error + base::kPi - half};
}

}  // namespace

Tows::Tows(const MatTexture& texture, std::uint64_t seed)
    : weave_(texture.weave),
      warp_seed_(base::DeriveSeed(seed, "warp")),
      weft_seed_(base::DeriveSeed(seed, "weft")),
      fuzz_seed_(base::DeriveSeed(seed, "fuzz")),
      wave_seed_(base::DeriveSeed(seed, "waves")),
      relief_m_(texture.weave_relief_m),
      fuzz_m_(texture.fuzz_m / std::sqrt(kPlaneNoiseVariance)),
      fuzz_per_m_(1.0 / texture.fuzz_length_m),
      wave_m_(texture.waviness_m / std::sqrt(kPlaneNoiseVariance)),
      waves_per_m_(1.0 / texture.waviness_length_m),
      brightness_(Mix(1.0, kBlackReturn, texture.darkness)) {
  const auto [p_angle, q_angle] = TowAngles(weave_, seed);
  px_ = std::cos(p_angle) / texture.weave_period_m;
  py_ = std::sin(p_angle) / texture.weave_period_m;
  qx_ = std::cos(q_angle) / texture.weave_period_m;
  qy_ = std::sin(q_angle) / texture.weave_period_m;
  // Light from straight above leaves a fibre in the plane across it. The camera stands in the plane
  // across x: tows along x show it most, tows along y least.
  const auto away = [&](double across_angle) {
    const double along_y = std::cos(across_angle);
    return texture.gloss * (kAwayAlongX + kAwayMoreAlongY * along_y * along_y);
  };
  warp_away_ = away(q_angle);
  weft_away_ = away(p_angle);
}

// Warp runs along growing p at one q, weft along growing q at one p. Over n and under n: the sum of
// the cells' numbers modulo 2n tells who is on top. Both shapes are 0 where the top changes.
Tows::Top Tows::TopAt(double p, double q) const {
  const Cell i(p);
  const Cell j(q);
  if (weave_ == Weave::kUniDirectional) {
    return {j.rest, 0.5, j.index, p, warp_away_, warp_seed_};
  }
  const std::int64_t n = weave_ == Weave::kPlaited ? 2 : 1;
  const std::int64_t phase = (i.index + j.index) & (2 * n - 1);
  const double part = static_cast<double>(phase % n);
  const double length = static_cast<double>(n);
  if (phase < n) return {j.rest, (part + i.rest) / length, j.index, p, warp_away_, warp_seed_};
  return {i.rest, (part + j.rest) / length, i.index, q, weft_away_, weft_seed_};
}

// Share of the light that goes elsewhere: whole stretches of a tow do or do not.
double Tows::AwayAt(const Top& top) const {
  if (top.away <= 0.0) return 0.0;
  const Cell stretch(top.position / kStretch);
  const auto sends_away = [&](std::int64_t index) {
    return Unit(Hash(top.seed, top.tow, index), 0) < top.away ? 1.0 : 0.0;
  };
  return Mix(sends_away(stretch.index), sends_away(stretch.index + 1), Ramp(stretch.rest));
}

MatPoint Tows::At(double x_m, double y_m) const {
  const double p = px_ * x_m + py_ * y_m;
  const double q = qx_ * x_m + qy_ * y_m;
  const Top top = TopAt(p, q);
  MatPoint point{0.0, brightness_ * Mix(1.0, kAwayReturn, AwayAt(top))};
  if (weave_ == Weave::kUniDirectional) {
    const double from_thread =
        std::abs(Cell(p / kThreadSpacing).rest - 0.5) * kThreadSpacing / (0.5 * kThreadWidth);
    const double thread = 1.0 - Ramp(from_thread);
    point.height_m = relief_m_ * (AcrossShape(top.across) - kMeanRidge + kThreadHeight * thread);
    point.return_strength = Mix(point.return_strength, 1.0, thread);
  } else {
    point.height_m = relief_m_ * (AcrossShape(top.across) * AlongShape(top.along) - kMeanRelief);
  }
  if (fuzz_m_ > 0.0) {
    point.height_m +=
        fuzz_m_ * Noise(fuzz_seed_, x_m * fuzz_per_m_, y_m * fuzz_per_m_ / kFuzzStretch);
  }
  if (wave_m_ > 0.0) {
    point.height_m += wave_m_ * Noise(wave_seed_, x_m * waves_per_m_, y_m * waves_per_m_);
  }
  return point;
}

}  // namespace rangegrasp::stitching::internal
