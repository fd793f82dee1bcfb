#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/internal/contacts.h"
#include "sim/internal/grip_control.h"
#include "sim/internal/hand_motors.h"

namespace rangegrasp::sim::internal {

/// GripControl on the hand of a world: reads joints and fingertips, and drives. One geared motor
/// ("hand_motor") closes the joints of "hand_joints", whose lower limits follow them where the gear
/// cannot be driven back (Ratchet); of a hand that says how it closes ("hand_motors") angles are
/// shares of closing.
class HandController {
 public:
  /// @throws base::InputError naming what the scene lacks ("hand_joints", "hand_motor", or what
  /// "hand_motors" asks for.
  HandController(World& world, const HandGeoms& hand, const HandControlOptions& options);

  void Preshape(double gap_m);  ///< moves to the angle with at least this gap
  void Close(bool firm) { control_.Close(firm); }
  void Open();
  void Tick(bool slips);  ///< once before each step. @param slips  what the pads hear

  bool Preshaped() const;
  bool Gripping() const { return control_.Gripping(); }
  bool FullyClosed() const;  ///< at the end of its range
  double Aperture() const;   ///< of the driven joints, from that end [rad, or share of closing]
  /// Whether the joints stand where the tips would meet, or almost: the hand holds nothing. Known
  /// of a real hand by closing it on nothing once.
  bool FeelsEmpty();
  bool FullyOpen() const;
  double force_N() const { return control_.force_N(); }  ///< command
  double strongest_N() const { return drive_.max_force_N; }
  double FeltForce() const;  ///< on the pads of the side that is pressed less [N]
  /// Where the pads are in W that are pressed harder.
  std::vector<Eigen::Vector3d> PressedPads(double least_N) const;
  int slips_heard() const { return control_.slips_heard(); }

 private:
  double Angle() const;
  double Speed() const;
  double AngleOfGap(double gap_m, int halvings = 0) const;
  void FeelPressure(HandReading& reading) const;
  void RatchetJoints();
  void DriveMotors();
  double OpenEnd() const { return motors_ ? 0.0 : open_limit_[0]; }
  double ClosedEnd() const;

  World* world_;
  const HandGeoms* hand_;
  HandDrive drive_;
  HandControlOptions options_;
  std::optional<HandMotors> motors_;
  std::vector<int> joints_;         // of one geared motor
  std::vector<double> open_limit_;  // lower ends of the joints' ranges, before any ratchet
  int motor_ = -1;
  GripControl control_;
  double target_angle_ = 0.0;
  double set_share_ = 0.0;  // of closing, that the motors are sent to
  std::optional<double> empty_angle_;
};

}  // namespace rangegrasp::sim::internal
