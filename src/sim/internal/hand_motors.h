#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "robot/mjcf/hand_closing.h"

namespace rangegrasp::sim::internal {

/// The drives of a hand that says how it closes ("hand_motors"), moved by one number: the share of
/// closing, 0 .. 1. Each is a servo of its own stiffness whose force is limited, as the controllers
/// of real grippers are; nothing locks.
class HandMotors {
 public:
  /// @param strongest_N  between the two sides: what a plain motor's servo is made stiff for
  /// @throws base::InputError if the hand's file says too little, or what cannot be.
  HandMotors(mjModel* model, double strongest_N);

  const mjcf::HandClosing& closing() const { return closing_; }
  /// The share that explains best where the drives stand: their least squares.
  double Share(const mjData* data) const;
  double Speed(const mjData* data) const;  ///< [1/s]

  /// Servos go to a share of closing.
  void Follow(mjData* data, double share) const;
  /// The same; what they meet is pressed with no more than force_N, but for what their own damping
  /// takes.
  void Press(mjData* data, double share, double force_N) const;
  /// Both sides are to press with a force from now on: the hand's shape, as it is, is kept while
  /// the share of closing is free.
  void BeginGrip(const mjData* data);
  void Grip(mjData* data, double force_N) const;

 private:
  struct Drive {
    mjcf::HandMotor motor;
    mjcf::AffineDrive affine;
    double stiffness = 0.0;   ///< [N/m or Nm/rad], > 0
    double per_newton = 0.0;  ///< largest force on the way for 1 N between the sides
    double held = 0.0;        ///< where it stood when the grip began
  };
  void ServePlainMotor(Drive& drive, double strongest_N);
  double Wanted(const Drive& drive, const mjData* data, double share) const;
  double Damping(const Drive& drive, const mjData* data) const;
  void Command(mjData* data, const Drive& drive, double force) const;

  mjModel* model_;
  mjcf::HandClosing closing_;
  std::vector<Drive> drives_;
  std::vector<mjcf::HandMotor> motors_;
  int tool_ = -1;
  double held_share_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
