#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/execute.h"
#include "sim/internal/contacts.h"

namespace rangegrasp::sim::internal {

/// The drive of a hand: one motor.
struct HandDrive {
  double first_force_N = 20.0;  ///< of the prosthesis: its slip control begins there
  double max_force_N = 100.0;
  double torque_per_force_Nm_N = 0.135;  ///< of the motor, for a newton between the tips
  double damping_Nm_s = 6.1;             ///< of the motor, per rad/s; 0: it has none
  double backlash_rad = 0.008;           ///< of the gear; infinite: it can be driven back
  /// A motor that turns slower stalls: 4 mm/s between the tips, where the free one makes 300.
  double stall_speed_rad_s = 0.03;
};

/// What the real hand feels: of the driven joints, pressure on the pads, whether one hears a slide,
/// the load that it holds.
struct HandReading {
  double angle_rad = 0.0, speed_rad_s = 0.0;
  double thumb_N = 0.0, fingers_N = 0.0;
  bool slips = false;
  Eigen::Vector3d load_H = Eigen::Vector3d::Zero();  ///< [N] in the hand's root frame
};

/// What the hand's motor does, from what the hand feels. Positive angles and torques close.
/// Closing runs at the speed limit, with a limited current, until both sides feel pressure (or the
/// motor stalls), then the force rises to the first grip; each slip felt after that adds to it, up
/// to the largest force. It returns to the first grip when the load is gone: when nothing slips and
/// nothing draws any more to where the load drew when it last slipped.
class GripControl {
 public:
  GripControl(const HandControlOptions& options, const HandDrive& drive, double timestep_s)
      : options_(options), drive_(drive), timestep_s_(timestep_s) {}

  void Preshape(double from_rad, double to_rad);  ///< at the closing speed, and holds it
  void Close(bool firm = false);  ///< @param firm  the first grip is the strongest one
  void Open();
  /// Once a time step. @return the motor's torque [Nm].
  double Tick(const HandReading& reading);

  enum class Mode { kPreshape, kClosing, kGripping, kOpening };
  Mode mode() const { return mode_; }
  bool Closing() const { return mode_ == Mode::kClosing; }
  bool Ratchets() const { return mode_ == Mode::kClosing || mode_ == Mode::kGripping; }
  bool Gripping() const;  ///< the first grip is reached
  double force_N() const { return force_N_; }
  double moving_force_N() const;                           ///< what a moving hand may shove with
  double commanded_rad() const { return commanded_rad_; }  ///< of the pre-shape, now
  int slips_heard() const { return slips_heard_; }         ///< each raised the force

 private:
  double MovingTorque(double speed_rad_s) const;
  double TickClosing(const HandReading& reading);
  double TickGripping(const HandReading& reading);
  bool HearsSlip(const HandReading& reading);
  bool LoadIsGone(const HandReading& reading);
  bool Stalls(double speed_rad_s);

  HandControlOptions options_;
  HandDrive drive_;
  double timestep_s_;
  Mode mode_ = Mode::kPreshape;
  double target_rad_ = 0.0, commanded_rad_ = 0.0;
  double force_N_ = 0.0, first_force_N_ = 0.0;
  double stalled_s_ = 0.0, gripping_s_ = 0.0, since_slip_s_ = 0.0, unloaded_s_ = 0.0;
  Eigen::Vector3d slipped_along_H_ = Eigen::Vector3d::Zero();  // unit: the load of the last slip
  int slips_heard_ = 0;
};

/// The lower limit of a joint whose gear is not back-drivable, from the one that it had and its
/// range's upper end: it follows the angle, less the gear's backlash (without that it would lock in
/// the blow of the closing fingers), and never falls.
double Ratchet(double lower_rad, double upper_rad, double angle_rad, double backlash_rad);

/// The drives of a hand that says how it closes ("hand_motors"), moved by the share of closing,
/// 0 .. 1. Each is a servo whose force is limited, as of real grippers; nothing locks.
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
  /// The same, but no further than where they press with force_N between the sides, and with what
  /// their own damping takes: the hand keeps its shape where it meets something.
  void Press(mjData* data, double share, double force_N) const;
  /// Both sides press with a force from now on: the hand keeps its shape, the share is free.
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
  /// The least squares of what the drives have of their ways each.
  template <class Function>
  double Along(const Function& of) const {
    double along = 0.0;
    double whole = 0.0;
    for (const Drive& drive : drives_) {
      const double way = drive.motor.Travel();
      along += way * of(drive);
      whole += way * way;
    }
    return along / whole;
  }
  double At(const Drive& drive, const mjData* data) const {
    return mjcf::DriveLength(model_, data, drive.motor.actuator);
  }
  double Wanted(const Drive& drive, const mjData* data, double share) const;
  double Damping(const Drive& drive, const mjData* data) const;
  void Command(mjData* data, const Drive& drive, double force) const;

  mjModel* model_;
  mjcf::HandClosing closing_;
  std::vector<Drive> drives_;
  std::vector<mjcf::HandMotor> motors_;
  int tool_ = -1;
  double work_per_newton_m_ = 0.0;  ///< of all drives for a whole way, at the most
  double held_share_ = 0.0;
};

/// GripControl on the hand of a world. One geared motor ("hand_motor") closes the joints of
/// "hand_joints", whose lower limits follow them where the gear cannot be driven back (Ratchet); of
/// a hand that says how it closes ("hand_motors") angles are shares of closing.
class HandController {
 public:
  /// @throws base::InputError naming what the scene lacks ("hand_joints", "hand_motor", or what
  /// "hand_motors" asks for.
  HandController(World& world, const HandGeoms& hand, const HandControlOptions& options);

  void Preshape(double gap_m);  ///< moves to the angle with at least this gap
  void Close(bool firm) { control_.Close(firm); }
  void Open();
  /// Once before each step.
  /// @param slips  what the pads hear
  /// @param load_W  sum of the forces of what the hand touches [N]
  void Tick(bool slips, const Eigen::Vector3d& load_W);

  bool Preshaped() const;
  bool Gripping() const { return control_.Gripping(); }
  bool FullyClosed() const;  ///< at the end of its range
  double Aperture() const;   ///< of the driven joints, from that end [rad, or share of closing]
  /// Whether the joints stand where the tips (almost) meet, as known of a real hand by closing it
  /// on nothing once.
  bool FeelsEmpty();
  bool FullyOpen() const;
  double force_N() const { return control_.force_N(); }  ///< command
  double strongest_N() const { return drive_.max_force_N; }
  double FeltForce() const;  ///< on the pads of the side that is pressed less [N]
  std::vector<Eigen::Vector3d> PressedPads(double least_N) const;  ///< places in W
  int slips_heard() const { return control_.slips_heard(); }

 private:
  double MeanOf(const mjtNum* values, const int* address) const;  // by joint
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
