#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/execute.h"
#include "sim/internal/contacts.h"

namespace rangegrasp::sim::internal {

/// Drive of a hand with one motor.
struct HandDrive {
  double first_force_N = 20.0;  ///< the prosthesis starts its slip control at this force
  double max_force_N = 100.0;
  double torque_per_force_Nm_N = 0.135;  ///< motor torque per N between the fingertips
  double damping_Nm_s = 6.1;             ///< of the motor, per rad/s; 0: none
  double backlash_rad = 0.008;           ///< of the gear; infinite: it is back-drivable
  /// A slower motor stalls: 4 mm/s between the tips, where a free motor reaches 300 mm/s.
  double stall_speed_rad_s = 0.03;
};

/// Sensor readings of a real hand: the driven joints, pressure on the pads, whether a pad detects a
/// slip, and the load that the hand holds.
struct HandReading {
  double angle_rad = 0.0, speed_rad_s = 0.0;
  double thumb_N = 0.0, fingers_N = 0.0;
  bool slips = false;
  Eigen::Vector3d load_H = Eigen::Vector3d::Zero();  ///< [N] in the hand's root frame
};

/// Controls the hand's motor from what the hand feels. Positive angles and torques close. The hand
/// closes at the speed limit with limited current until both sides feel pressure (or the motor
/// stalls). Then the force rises to the initial grip force, and each slip felt after that adds to
/// it, up to the maximum. It returns to the initial force when the load is gone: nothing slips and
/// nothing pulls any more in the direction of the load at the last slip.
class GripControl {
 public:
  GripControl(const HandControlOptions& options, const HandDrive& drive, double timestep_s)
      : options_(options), drive_(drive), timestep_s_(timestep_s) {}

  void Preshape(double from_rad, double to_rad);  ///< at the closing speed, and holds it
  void Close(bool firm = false);                  ///< @param firm  starts with the maximum force
  void Open();
  /// To be called once per time step.
  /// @return the motor's torque [Nm].
  double Tick(const HandReading& reading);

  enum class Mode { kPreshape, kClosing, kGripping, kOpening };
  Mode mode() const { return mode_; }
  bool Ratchets() const { return mode_ == Mode::kClosing || mode_ == Mode::kGripping; }
  bool Gripping() const;  ///< the initial grip force is reached
  double force_N() const { return force_N_; }
  double moving_force_N() const;                           ///< largest push of a moving hand
  double commanded_rad() const { return commanded_rad_; }  ///< present pre-shape command
  int slips_heard() const { return slips_heard_; }         ///< slips detected; each raised force

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
  Eigen::Vector3d slipped_along_H_ = Eigen::Vector3d::Zero();  // unit: load at last slip
  int slips_heard_ = 0;
};

/// The new lower limit of a joint whose gear is not back-drivable, from its present one and its
/// range's upper end. It follows the angle less the gear's backlash and never decreases. Without
/// the backlash it would lock in the impact of the closing fingers.
double Ratchet(double lower_rad, double upper_rad, double angle_rad, double backlash_rad);

/// The drives of a hand that states how it closes ("hand_motors"), moved by the share of closing,
/// 0..1. Each is a servo with limited force, as in real grippers; nothing locks.
class HandMotors {
 public:
  /// @param strongest_N  between the two sides; sets the stiffness of a plain motor's servo
  /// @throws base::InputError if the hand's file gives too little or impossible data.
  HandMotors(mjModel* model, double strongest_N);

  const mjcf::HandClosing& closing() const { return closing_; }
  /// The share of closing that fits the drives' positions best (least squares).
  double Share(const mjData* data) const;
  double Speed(const mjData* data) const;  ///< [1/s]

  /// Sends the servos to a share of closing.
  void Follow(mjData* data, double share) const;
  /// The same, but only as far as they press with force_N between the sides plus the loss to their
  /// own damping: the hand keeps its shape when it meets something.
  void Press(mjData* data, double share, double force_N) const;
  /// From now on both sides press with a force: the hand keeps its shape, its share is free.
  void BeginGrip(const mjData* data);
  void Grip(mjData* data, double force_N) const;

 private:
  struct Drive {
    mjcf::HandMotor motor;
    mjcf::AffineDrive affine;
    double stiffness = 0.0;   ///< [N/m or Nm/rad], > 0
    double per_newton = 0.0;  ///< largest force over the travel for 1 N between the sides
    double held = 0.0;        ///< position when the grip began
  };
  void ServePlainMotor(Drive& drive, double strongest_N);
  /// Least-squares share of travel over all drives, from a displacement of each.
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
  double work_per_newton_m_ = 0.0;  ///< upper bound over all drives for the full travel
  double held_share_ = 0.0;
};

/// GripControl on the hand of a world. One geared motor ("hand_motor") closes the joints of
/// "hand_joints"; their lower limits follow them if the gear is not back-drivable (Ratchet). For a
/// hand that states how it closes ("hand_motors"), angles are shares of closing.
class HandController {
 public:
  /// @throws base::InputError naming what the scene lacks ("hand_joints", "hand_motor", or what
  /// "hand_motors" requires).
  HandController(World& world, const HandGeoms& hand, const HandControlOptions& options);

  void Preshape(double gap_m);  ///< moves to the angle with at least this gap
  void Close(bool firm) { control_.Close(firm); }
  void Open();
  /// To be called once before each step.
  /// @param slips  whether the pads detect a slip
  /// @param load_W  sum of the contact forces on the hand [N]
  void Tick(bool slips, const Eigen::Vector3d& load_W);

  bool Preshaped() const;
  bool Gripping() const { return control_.Gripping(); }
  bool FullyClosed() const;  ///< at the end of its range
  double Aperture() const;   ///< of the driven joints, from that end [rad, or share of closing]
  /// Whether the joints are where the tips (almost) meet. A real hand learns this by closing on
  /// nothing once.
  bool FeelsEmpty();
  bool FullyOpen() const;
  double force_N() const { return control_.force_N(); }  ///< commanded
  double strongest_N() const { return drive_.max_force_N; }
  double FeltForce() const;  ///< on the pads of the less loaded side [N]
  int slips_heard() const { return control_.slips_heard(); }

 private:
  double MeanOf(const mjtNum* values, const int* address) const;  // by joint
  double Angle() const;
  double Speed() const;
  double AngleOfGap(double gap_m, int halvings = 0) const;
  void FeelPressure(HandReading& reading) const;
  void RatchetJoints();
  void DriveMotors();
  double ClosedEnd() const;

  World* world_;
  const HandGeoms* hand_;
  HandDrive drive_;
  HandControlOptions options_;
  std::optional<HandMotors> motors_;
  std::vector<int> joints_;         // driven by one geared motor
  std::vector<double> open_limit_;  // lower ends of the joints' ranges, before any ratchet
  int motor_ = -1;
  GripControl control_;
  double target_angle_ = 0.0;
  double set_share_ = 0.0;  // commanded share of closing
  std::optional<double> empty_angle_;
};

}  // namespace rangegrasp::sim::internal
