#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "robot/mjcf/hand_file.h"

namespace rangegrasp::mjcf {

/// The hand closing on nothing, all drives together: at share s each stands at
/// open + s (closed - open). What they do not drive (followers, four-bar linkages that equalities
/// close, springs) stands where the model itself takes it.
struct HandClosing {
  struct Point {
    double share = 0.0;  ///< 0 .. 1
    double gap_m = 0.0;  ///< least distance of the two sides' last segments; negative: overlap
    std::vector<double> positions;  ///< of `joints`
  };
  std::vector<int> joints;    ///< all of the hand
  std::vector<Point> points;  ///< ascending, evenly spaced, the first at 0, the last at 1

  // How well the model followed, for checks.
  double equality_m = 0.0;   ///< largest error of an equality [rad or m]
  int equality = -1;         ///< whose
  double behind = 0.0;       ///< share of its travel by which a drive stopped short of its end
  int behind_actuator = -1;  ///< which

  double GapAt(double share) const;
  /// The way that the gap narrows for a whole travel, at a share [m].
  double NarrowingAt(double share) const;
  /// The share at which the sides first touch; 1 if they never do.
  double Touching() const;
  /// The largest share up to which the gap is at least gap_m; 0 if it never is.
  double ShareAtGap(double gap_m) const;
  /// Puts the hand's joints there; kinematics are the caller's.
  void Pose(const mjModel* model, mjData* data, double share) const;
};

/// Closes a copy of the hand step by step: no gravity, no contacts, every drive a stiff servo
/// without limits, the arm and all else as it stands in qpos0. A few thousand steps, 20 to 60 ms.
/// @throws base::InputError as HandMotors(); if the hand does not stay finite.
HandClosing CloseOnNothing(const mjModel* model);
/// The same with other ends of the drives' ways than the file's.
HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors);

}  // namespace rangegrasp::mjcf
