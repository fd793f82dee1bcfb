#pragma once

#include <Eigen/Core>

#include "grasp/closing.h"
#include "grasp/grasp_options.h"

namespace rangegrasp::grasp {

/// What a refined grasp is scored by. Each term is 0 where it is best and 1 where it is bad.
struct Quality {
  AntipodalAngles angles;  ///< of the contacts that closing the hand model finds
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;  ///< measured: about 12.5 deg for cylinders, 8 deg for others
  double lever_m = 0.0;         ///< the centre of mass beside the contacts' line, across it
  double above_m = 0.0;         ///< the contacts above the centre of mass; negative: below
  double drag_m = 0.0;          ///< of the object by the hand that closes
  double slope_m = 0.0;         ///< difference in height of the two contacts
  double top_margin_m = 0.0;    ///< of the contacts below the object's top
  double contact_m2 = 0.0;      ///< within 3 mm of the pads
  double room_m = 0.0;          ///< largest gap of the hand less the width
  double thumb_to_arm = 0.0;    ///< cosine between the closing direction and the way to the arm
};

/// score = 1 - antipodal A - pitch P - lever L - height H - drag D - slope S - shallow M - room R
///         + tight T + arm C, with
///   A = (larger of both antipodal angles / friction cone)^2, at most 4,
///   P = ((pitch - best pitch) / scale)^2, at most 4,      L = (lever / scale)^2, at most 4,
///   H = (height of the contacts above the centre of mass / scale)^2, at most 2,
///   D, S = |drag|, |slope| / scale, at most 2,
///   M = how much the contacts miss of the margin below the top, 0 to 2,
///   R = (how much room misses of its scale)^2, 0 to 1,
///   T = contact area / scale, at most 1,                  C = thumb_to_arm.
/// The scales and the bounds 4 and 2 stand in ScoreWeights.
double Score(const Quality& quality, double friction_cone_rad, const ScoreWeights& weights);

}  // namespace rangegrasp::grasp
