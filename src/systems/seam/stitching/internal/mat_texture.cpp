#include "seam/stitching/internal/mat_texture.h"

#include "base/units.h"

namespace rangegrasp::seam {
namespace {

// Section 3.1.1 describes the mats and shows fibres but gives no figures: these constants only set
// their shape. The values that affect the rates most are options of MatTexture, chosen by a fit.

// A black mat still returns this much: ten times the loss threshold of the base sensor.
constexpr double kBlackReturn = 0.1;
// Return of a stretch of tow that reflects light away: between the loss thresholds of the two
// sensors (0.01 and 0.1), so that one sees it and the other does not.
constexpr double kAwayReturn = 0.06;
// Approximate length of stretches with the same reflection [tow widths].
constexpr double kStretch = 3.0;
// Threads that hold a uni-directional mat together: spacing and width [tow widths], and height
// above it [reliefs].
constexpr double kThreadSpacing = 2.5;
constexpr double kThreadWidth = 0.12;
constexpr double kThreadHeight = 0.5;
// Angle error of a fabric [rad], and half the angle between plaited tows.
constexpr double kMaxAngleError_rad = 0.1;
constexpr Range kPlaitHalf_rad = {0.5, 0.8};
// Share of a glossy tow that reflects light away: for a tow along x, and how much more for a tow
// along y.
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
  const double half = kPlaitHalf_rad.Draw(rng);
  return {error + half, error + base::kPi - half};
}

// Filaments belong to cells of this size; none reaches further than its neighboring cells.
constexpr double kCell_m = 4e-3;
constexpr Range kLength_m = {1e-3, 2.0 * kCell_m};
constexpr double kMaxFilamentSlope = 0.9;  // dx/dy
// One to four columns of the base sensor.
constexpr Range kWidth_m = {0.1e-3, 0.3e-3};
constexpr Range kHeight = {0.2, 1.0};  // share of the full height
constexpr Range kReturn = {0.2, 1.0};  // share of the light
// There are no filaments beyond this many reaches: 1.8 % of an exponential distribution.
constexpr double kMaxDistance_reaches = 4.0;

// At most one bundle in each stretch of this length, and its distance on the low side.
constexpr double kStretch_m = 20e-3;
constexpr Range kBundleDistance_m = {1e-3, 3e-3};
constexpr Range kBundleWidth_m = {0.3e-3, 0.9e-3};  // below the 1 mm of an obstacle
constexpr double kBundleEnds_m = 1.5e-3;            // over which it sinks into the mat
// Shares of the edge's height and of the light.
constexpr Range kBundleHeight = {0.6, 1.2};
constexpr Range kBundleReturn = {0.4, 1.0};
// Margin of a bundle from the ends of the range of distances, as a share of the range.
constexpr double kBundlePlaceMargin = 0.1;
// A bundle wanders about its place by half of this.
constexpr double kBundleWander = 0.2;
// Variation of the share of a stretch that a bundle fills.
constexpr double kBundleLengthSpread = 0.2;

// A bump of height 1 for |t| < 1, with a continuous first derivative.
double Bump(double t) {
  const double u = 1.0 - t * t;
  return u > 0.0 ? u * u : 0.0;
}

void Raise(MatPoint& highest, double height_m, double return_strength) {
  if (height_m > highest.height_m) highest = {height_m, return_strength};
}

// Raises the height at (dx, dy) to that of a filament from two hashes, with its middle at (0, 0).
void RaiseFilament(std::uint64_t a, std::uint64_t b, double dx, double dy, double full_height_m,
                   MatPoint& highest) {
  const double u = Unit(a, 2);
  const double length = kLength_m.At(u * u);  // most are short
  const double along = 2.0 * dy / length;
  if (along <= -1.0 || along >= 1.0) return;
  const double slope = kMaxFilamentSlope * (2.0 * Unit(b, 0) - 1.0);
  const double across = 2.0 * (dx - slope * dy) / kWidth_m.At(Unit(b, 1));
  if (across <= -1.0 || across >= 1.0) return;
  const double height = full_height_m * kHeight.At(Unit(b, 2));
  Raise(highest, height * (1.0 - along * along) * Bump(across), kReturn.At(Unit(b, 3)));
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
  // A fibre reflects light from straight above in the plane across it. The camera is in the plane
  // across x: it sees most of the light of tows along x, and least of tows along y.
  const auto away = [&](double across_angle) {
    const double along_y = std::cos(across_angle);
    return texture.gloss * (kAwayAlongX + kAwayMoreAlongY * along_y * along_y);
  };
  warp_away_ = away(q_angle);
  weft_away_ = away(p_angle);
}

// Warp runs along increasing p at one q, weft along increasing q at one p. Each passes over n and
// under n: the sum of the cell indices modulo 2n determines which is on top. Both shapes are 0
// where the top changes.
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

// Share of the light that is reflected away: by whole stretches of a tow.
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

Filaments::Filaments(const MatTexture& texture, double edge_height_m, std::uint64_t seed)
    : edge_seed_(base::DeriveSeed(seed, "filaments")),
      loose_seed_(base::DeriveSeed(seed, "loose filaments")),
      detached_seed_(base::DeriveSeed(seed, "detached")),
      per_edge_cell_(texture.filaments_per_m * kCell_m),
      per_loose_cell_(texture.loose_filaments_per_m2 * kCell_m * kCell_m),
      height_m_(texture.filament_height_m),
      reach_m_(texture.filament_reach_m),
      edge_height_m_(edge_height_m),
      detached_share_(texture.detached_share) {}

MatPoint Filaments::NearEdge(double across_m, double y_m) const {
  MatPoint highest{0.0, 0.0};
  Detached(across_m, y_m, highest);
  const double max_distance =
      kMaxDistance_reaches * reach_m_ + kMaxFilamentSlope * kCell_m + kWidth_m.high;
  if (per_edge_cell_ <= 0.0 || std::abs(across_m) > max_distance) return highest;
  const Cell middle(y_m / kCell_m);
  for (std::int64_t j = middle.index - 1; j <= middle.index + 1; ++j) {
    // Twice a uniform value times the mean: frayed and clean stretches alternate.
    const std::uint64_t cell = Hash(edge_seed_, j);
    const auto count =
        static_cast<std::int64_t>(2.0 * Unit(cell, 0) * per_edge_cell_ + Unit(cell, 1));
    for (std::int64_t k = 1; k <= count; ++k) {
      const std::uint64_t a = Hash(cell, k);
      const double dy = y_m - (static_cast<double>(j) + Unit(a, 0)) * kCell_m;
      if (std::abs(dy) >= 0.5 * kLength_m.high) continue;
      const double side = 2.0 * Unit(a, 1) - 1.0;
      const double distance =
          -reach_m_ * std::log1p(-std::abs(side) * (1.0 - std::exp(-kMaxDistance_reaches)));
      RaiseFilament(a, Hash(cell, -k), across_m - std::copysign(distance, side), dy, height_m_,
                    highest);
    }
  }
  return highest;
}

MatPoint Filaments::Elsewhere(double x_m, double y_m) const {
  MatPoint highest{0.0, 0.0};
  if (per_loose_cell_ <= 0.0) return highest;
  const Cell column(x_m / kCell_m);
  const Cell row(y_m / kCell_m);
  for (std::int64_t j = row.index - 1; j <= row.index + 1; ++j) {
    for (std::int64_t i = column.index - 1; i <= column.index + 1; ++i) {
      const std::uint64_t cell = Hash(loose_seed_, i, j);
      const auto count = static_cast<std::int64_t>(per_loose_cell_ + Unit(cell, 0));
      for (std::int64_t k = 1; k <= count; ++k) {
        const std::uint64_t a = Hash(cell, k);
        RaiseFilament(a, Hash(cell, -k), x_m - (static_cast<double>(i) + Unit(a, 0)) * kCell_m,
                      y_m - (static_cast<double>(j) + Unit(a, 1)) * kCell_m, height_m_, highest);
      }
    }
  }
  return highest;
}

// A stretch has a bundle with probability `chance`; its mean length compensates for this.
void Filaments::Detached(double across_m, double y_m, MatPoint& highest) const {
  if (detached_share_ <= 0.0) return;
  if (across_m > 0.0 || across_m < -kBundleDistance_m.high - kBundleWidth_m.high) return;
  const Cell stretch(y_m / kStretch_m);
  const std::uint64_t a = Hash(detached_seed_, stretch.index);
  const double chance = std::min(1.0, 2.0 * detached_share_);
  if (Unit(a, 0) >= chance) return;
  const double mean = detached_share_ / chance;
  const double length = mean + (2.0 * Unit(a, 1) - 1.0) * std::min(kBundleLengthSpread, 1.0 - mean);
  const double begin = Unit(a, 2) * (1.0 - length);
  const double from_end_m =
      std::min(stretch.rest - begin, begin + length - stretch.rest) * kStretch_m;
  const double along = Ramp(from_end_m / kBundleEnds_m);
  if (along <= 0.0) return;
  const std::uint64_t b = Hash(a, 1);
  // It wanders a little, so that it is not exactly parallel to the edge.
  const double wander = kBundleWander * Noise(b, y_m / kCell_m);
  const double place = kBundleDistance_m.At(
      Mix(kBundlePlaceMargin, 1.0 - kBundlePlaceMargin, Unit(b, 0)) + 0.5 * wander);
  const double half = 0.5 * kBundleWidth_m.At(Unit(b, 1));
  const double height = edge_height_m_ * kBundleHeight.At(Unit(b, 2));
  Raise(highest, height * along * Bump((across_m + place) / half), kBundleReturn.At(Unit(b, 3)));
}

}  // namespace rangegrasp::seam
