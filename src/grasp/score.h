#pragma once

#include <Eigen/Core>

#include "grasp/closing.h"

namespace rangegrasp::grasp {

/// What a refined grasp is judged by. Each term is 0 where it is best and 1 where it is bad.
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

/// Weights and scales of Score(), in one place for tuning against physics.
struct ScoreWeights {
  double antipodal = 1.0;
  double pitch = 0.4;
  double lever = 0.5;
  double height = 0.25;
  double drag = 0.2;
  double slope = 0.1;
  double shallow = 0.5;
  double tight = 0.3;
  double room = 0.2;
  double arm = 0.1;

  double pitch_scale_rad = 0.1745;  ///< 10 deg
  double lever_scale_m = 0.020;
  double above_scale_m = 0.030;
  double below_scale_m = 0.050;
  double drag_scale_m = 0.016;  ///< what the coupled hand was seen to drag and still hold
  double slope_scale_m = 0.020;
  double margin_m = 0.012;         ///< contacts this far below the top are deep enough
  double contact_scale_m2 = 4e-4;  ///< two pads of 10 x 20 mm
  double room_scale_m = 0.015;
};

/// score = 1 - antipodal A - pitch P - lever L - height H - drag D - slope S - shallow M - room R
///         + tight T + arm C, with
///   A = (largest of both antipodal angles / friction cone)^2, capped at 4,
///   P = ((pitch - best pitch) / scale)^2, capped at 4,      L = (lever / scale)^2, capped at 4,
///   H = (height of the contacts above the centre of mass / scale)^2, capped at 2,
///   D, S = |drag|, |slope| / scale, capped at 2,
///   M = how much the contacts miss of the margin below the top, 0 to 2,
///   R = (how much room misses of its scale)^2, 0 to 1,
///   T = contact area / scale, capped at 1,                  C = thumb_to_arm.
double Score(const Quality& quality, double friction_cone_rad, const ScoreWeights& weights = {});

}  // namespace rangegrasp::grasp
