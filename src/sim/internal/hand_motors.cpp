#include "sim/internal/hand_motors.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "robot/mjcf/grip_forces.h"
#include "sim/internal/engine.h"
#include "sim/internal/kinematics.h"

namespace rangegrasp::sim::internal {
namespace {

// A plain motor is given a servo that presses with the strongest grip when it is so far from where
// it should be, as a share of its way, and comes there in about so long.
constexpr double kFullForceAt = 0.1;
constexpr double kServo_s = 0.05;
// Where on the way forces are looked at, from the open to the touching hand.
constexpr int kSamples = 12;

}  // namespace

HandMotors::HandMotors(mjModel* model, double strongest_N)
    : model_(model), motors_(mjcf::HandMotors(model)), tool_(mjcf::ToolSite(model, "tcp_tip")) {
  if (tool_ < 0) throw base::InputError("the hand has no site \"tcp\"");
  CallEngine(nullptr, [&] { closing_ = mjcf::CloseOnNothing(model); });
  DataPtr scratch(mj_makeData(model));
  for (const mjcf::HandMotor& motor : motors_) drives_.push_back({motor, {}, 0.0, 0.0, 0.0});
  for (int i = 0; i < kSamples; ++i) {
    const double share = closing_.Touching() * i / (kSamples - 1);
    closing_.Pose(model, scratch.get(), share);
    CallEngine(nullptr, [&] { mj_forward(model, scratch.get()); });
    const auto forces = mjcf::GripForces(model, scratch.get(), motors_, closing_, share,
                                         internal::SitePose(scratch.get(), tool_).linear().col(0));
    for (std::size_t k = 0; k < drives_.size(); ++k) {
      drives_[k].per_newton = std::max(drives_[k].per_newton, std::abs(forces[k]));
    }
  }
  // What moves the fingers together shoves alike: by the work of the drive that does most.
  double work = 0.0;
  for (const Drive& drive : drives_) {
    work = std::max(work, drive.per_newton * std::abs(drive.motor.Travel()));
  }
  for (Drive& drive : drives_) {
    if (drive.motor.Moves()) drive.per_newton = work / std::abs(drive.motor.Travel());
    ServePlainMotor(drive, strongest_N);
  }
}

// A motor has neither stiffness nor damping: its controller gives it both, the damping in the
// engine's own terms, which are solved implicitly.
void HandMotors::ServePlainMotor(Drive& drive, double strongest_N) {
  const int a = drive.motor.actuator;
  drive.affine = mjcf::AffineOf(model_, a);
  if (drive.affine.bias[1] < 0.0) {
    drive.stiffness = -drive.affine.bias[1];
    return;
  }
  const double way = drive.motor.Moves() ? std::abs(drive.motor.Travel()) : 1.0;
  drive.stiffness = std::max(strongest_N * drive.per_newton, 1e-3) / (kFullForceAt * way);
  drive.affine.bias[2] = std::min(drive.affine.bias[2], -kServo_s * drive.stiffness);
  model_->actuator_biastype[a] = mjBIAS_AFFINE;
  model_->actuator_biasprm[a * mjNBIAS + 2] = drive.affine.bias[2];
}

double HandMotors::Share(const mjData* data) const {
  double along = 0.0;
  double whole = 0.0;
  for (const Drive& drive : drives_) {
    const double way = drive.motor.Travel();
    const double at = mjcf::DriveLength(model_, data, drive.motor.actuator);
    along += way * (at - drive.motor.open);
    whole += way * way;
  }
  return along / whole;
}

double HandMotors::Speed(const mjData* data) const {
  double along = 0.0;
  double whole = 0.0;
  for (const Drive& drive : drives_) {
    const double way = drive.motor.Travel();
    along += way * mjcf::DriveSpeed(model_, data, drive.motor.actuator);
    whole += way * way;
  }
  return along / whole;
}

double HandMotors::Wanted(const Drive& drive, const mjData* data, double share) const {
  const double goal = drive.motor.open + share * drive.motor.Travel();
  return drive.stiffness * (goal - mjcf::DriveLength(model_, data, drive.motor.actuator));
}

void HandMotors::Follow(mjData* data, double share) const {
  for (const Drive& drive : drives_) Command(data, drive, Wanted(drive, data, share));
}

// What a drive's own damping and that of the joints that it moves take of its force.
double HandMotors::Damping(const Drive& drive, const mjData* data) const {
  const int a = drive.motor.actuator;
  const int out = model_->actuator_outadr[a];
  double damping = std::abs(drive.affine.bias[2] * mjcf::DriveSpeed(model_, data, a));
  double of_joints = 0.0;
  for (int i = 0; i < data->moment_rownnz[out]; ++i) {
    const int at = data->moment_rowadr[out] + i;
    const int dof = data->moment_colind[at];
    const double moment = std::abs(data->actuator_moment[at]);
    if (moment <= 0.0) continue;
    of_joints = std::max(of_joints, model_->dof_damping[dof] * std::abs(data->qvel[dof]) / moment);
  }
  return damping + of_joints;
}

void HandMotors::Press(mjData* data, double share, double force_N) const {
  for (const Drive& drive : drives_) {
    const double wanted = Wanted(drive, data, share);
    const double limit = force_N * drive.per_newton + Damping(drive, data);
    Command(data, drive, drive.motor.Moves() ? std::clamp(wanted, -limit, limit) : wanted);
  }
}

void HandMotors::BeginGrip(const mjData* data) {
  held_share_ = Share(data);
  for (Drive& drive : drives_) {
    drive.held = mjcf::DriveLength(model_, data, drive.motor.actuator);
  }
}

void HandMotors::Grip(mjData* data, double force_N) const {
  const double share = Share(data);
  const auto forces = mjcf::GripForces(model_, data, motors_, closing_, share,
                                       internal::SitePose(data, tool_).linear().col(0));
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    const Drive& drive = drives_[k];
    const double shape = drive.held + (share - held_share_) * drive.motor.Travel();
    const double at = mjcf::DriveLength(model_, data, drive.motor.actuator);
    Command(data, drive, forces[k] * force_N + drive.stiffness * (shape - at));
  }
}

void HandMotors::Command(mjData* data, const Drive& drive, double force) const {
  const int a = drive.motor.actuator;
  const mjcf::AffineDrive& affine = drive.affine;
  const double at = mjcf::DriveLength(model_, data, a);
  data->ctrl[model_->actuator_ctrladr[a]] =
      (force - affine.bias[0] - affine.bias[1] * at) / affine.gain;
}

}  // namespace rangegrasp::sim::internal
