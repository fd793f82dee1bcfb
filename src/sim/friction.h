#pragma once

#include <string_view>

#include "sim/world.h"

namespace rangegrasp::sim {

/// What is known of the glove's friction on a surface: the static coefficient's range, its middle,
/// and the kinetic coefficient that goes with the middle.
struct GloveRange {
  double middle = 0.6;
  double low = 0.45;
  double high = 0.8;
  double kinetic = 0.5;
};

/// The surface of the scene, which the glove may touch too: the table's laminate.
inline constexpr std::string_view kTableSurface = "laminate";

/// The pair for a draw u from 0 to 1: the static coefficient is triangular over its range with the
/// middle as its mode, the kinetic one in the proportion of the table's two numbers.
FrictionPair DrawnFriction(const GloveRange& range, double u);

/// The glove's pair on a surface as the options choose it; drawn ones by u from 0 to 1.
/// glove_friction overrides both coefficients.
FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options, double u);
/// Likewise with the middle in the place of what would be drawn.
FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options);

/// Whether a contact slides, with hysteresis: it starts at 1 mm/s (above what held contacts creep,
/// 0.016 mm/s, below what a dropped object reaches in one step, 20 mm/s) and sticks again below
/// half of that. A contact that is lost for a moment (a sliding body chatters) has not stuck.
struct SlipState {
  static constexpr double kSlides_m_s = 0.001;
  static constexpr double kSticks_m_s = 0.0005;

  bool sliding = false;

  /// @param speed_m_s  tangential speed of the fastest contact; negative if there is none.
  void Update(double speed_m_s) {
    if (speed_m_s > kSlides_m_s) sliding = true;
    if (speed_m_s >= 0.0 && speed_m_s < kSticks_m_s) sliding = false;
  }
  double Coefficient(const FrictionPair& pair) const {
    return sliding ? pair.kinetic_mu : pair.static_mu;
  }
};

}  // namespace rangegrasp::sim
