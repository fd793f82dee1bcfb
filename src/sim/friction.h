#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/world.h"

namespace rangegrasp::sim {

/// Friction of a surface against what it meets in a trial.
struct SurfaceFriction {
  std::string_view surface;  ///< as in an object's custom text "surface"
  FrictionPair glove;        ///< the hand's PVC glove on it
  FrictionPair on_laminate;  ///< it on the table's laminate
};

/// The table of pairs, the one place where friction is stated (estimates consistent with published
/// rubber and plastic pairs; vary the glove's by +-0.15).
const std::vector<SurfaceFriction>& FrictionTable();

/// @throws core::InputError naming the surface and those that exist.
const SurfaceFriction& FrictionOf(std::string_view surface);

/// The glove's pair on a surface as the options change it: glove_friction overrides both
/// coefficients; else static_friction_offset is added to the static one (never below the kinetic
/// one), and kinetic_only takes the kinetic one for both.
FrictionPair GloveFriction(std::string_view surface, const PhysicsOptions& options);

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
