#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "sim/execute.h"
#include "sim/friction.h"
#include "sim/internal/contacts.h"

namespace rangegrasp::sim::internal {

/// The glove's friction on the target: each hand geom has the static coefficient until one of its
/// contacts slides, then the kinetic one until it sticks again.
class Glove {
 public:
  Glove(const HandGeoms& hand, const FrictionPair& pair) : hand_(&hand), pair_(pair) {}
  void Tick(mjModel* model, const mjData* data);
  bool Slides() const { return slides_; }  ///< any fingertip that touches something

 private:
  const HandGeoms* hand_;
  FrictionPair pair_;
  std::vector<SlipState> states_;
  bool slides_ = false;
};

/// One motor closes thumb and fingers. Positive control closes. What it reads is what the real hand
/// feels: the motor's angle and speed, the pressure on thumb and fingers, and slip at the
/// fingertips.
///
/// Closing runs at the speed limit until both sides feel pressure (or the motor stalls), then the
/// force rises to the first grip; each slip felt after that adds to it. The gear is not
/// back-drivable: while it closes, the lower limit of each driven joint follows its angle, less the
/// gear's backlash (without that it would lock in the blow of the closing fingers).
class HandController {
 public:
  HandController(World& world, const HandGeoms& hand, const HandControlOptions& options);

  void Preshape(double gap_m);  ///< moves to the angle with at least this gap
  void Close();
  void Open();
  void Tick(bool slides);  ///< once before each step

  bool Preshaped() const;
  bool Gripping() const;     ///< the first grip is reached
  bool FullyClosed() const;  ///< at the end of its range
  bool FullyOpen() const;
  double force_N() const { return force_N_; }

 private:
  enum class Mode { kPreshape, kClosing, kGripping, kOpening };

  double Angle() const;
  double Speed() const;
  double AngleOfGap(double gap_m) const;
  bool FeelsBothSides() const;
  bool Stalls();
  void TickClosing();
  void TickGripping(bool slides);
  void Ratchet();
  void Drive(double torque_Nm);

  World* world_;
  const HandGeoms* hand_;
  HandControlOptions options_;
  std::vector<int> joints_;
  std::vector<double> open_limit_;
  int motor_;
  double torque_per_force_;
  double speed_damping_;  ///< of the motor, Nm s/rad
  double backlash_rad_;

  Mode mode_ = Mode::kPreshape;
  double target_angle_ = 0.0;
  double commanded_angle_ = 0.0;
  double force_N_ = 0.0;
  double stalled_s_ = 0.0;
  double gripping_s_ = 0.0;
  double since_slip_s_ = 0.0;
};

}  // namespace rangegrasp::sim::internal
