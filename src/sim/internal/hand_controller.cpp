#include "sim/internal/hand_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim::internal {
namespace {

// Position gain of the pre-shape per motor damping: the hand lags the ramp by 0.09 rad, and the
// passive fingers' springs (two of 0.1 Nm/rad, over 0.75 rad) move it by 1 mrad.
constexpr double kPositionRate_1_s = 25.0;
constexpr double kLeastPositionGain_Nm_rad = 15.0;
// Smallest force that a side feels: a twentieth of the weakest grip. A larger value pushes light
// objects further before the grip.
constexpr double kFelt_N = 0.5;
// A motor that turns slowly for this long has stalled; starting up takes less.
constexpr double kStallTime_s = 0.06;
// The force rises from touch to the initial 20 N in 0.04 s, and returns to it at the same rate. A
// faster rise is an impact.
constexpr double kForceRate_N_s = 250.0;
// The initial grip is held this long before slip counts, because closing itself causes sliding.
constexpr double kFirstGripHold_s = 0.05;
// At most one slip is detected in this time, so that a force has time to act before the next.
constexpr double kSlipPeriod_s = 0.04;
// A smaller pull counts as no load: less than half of the lightest object's weight.
constexpr double kNoLoad_N = 0.5;
// The load is gone when there has been none for this long; contacts chatter for less.
constexpr double kLoadGone_s = 0.1;

// A plain motor gets a servo that presses with the maximum grip force at this share of its travel
// from its goal, and reaches the goal in about this time.
constexpr double kFullForceAt = 0.1;
constexpr double kServo_s = 0.05;
// Number of positions at which forces are evaluated, from the open to the touching hand.
constexpr int kSamples = 12;

// The hand's range is searched for a gap in this many steps: 0.7 deg or 1.7 mm of gap each.
constexpr int kGapSteps = 60;
// A joint has reached its target within this: 3 mm of gap, twice what the passive fingers' springs
// move it by; or 2 % of the travel of "hand_motors".
constexpr double kAtTarget_rad = 0.02;
// The smallest gap of the tips that a closed hand's joints distinguish from none. Held parts are
// thicker (the bowl's wall: 3 mm). On nothing, the passive fingers' springs leave up to 1.1 mm.
constexpr double kLeastFelt_m = 0.002;
// Halvings of one of the steps above: 0.03 mm of gap.
constexpr int kGapHalvings = 6;
// A joint is at its closed end within this: 1.4 mm of gap, where nothing can be held.
constexpr double kAtClosedEnd_rad = 0.01;

int MotorOf(const mjModel* model) {
  const auto motors = TupleOf(model, mjOBJ_ACTUATOR, "hand_motor");
  if (motors.size() != 1) throw base::InputError("tuple \"hand_motor\" must have one actuator");
  return motors[0];
}

// A hand with "hand_motors" closes over its full travel in this time (a Robotiq 2F-85: 0.57 s).
constexpr double kClosing_s = 0.5;
// The share of its closing speed below which a motor stalls, as for the geared motor.
constexpr double kStallShare = 0.03 / 2.2;

// The scene's own values where it gives them; forces in the options take precedence.
HandDrive DriveOf(const mjModel* model, const HandControlOptions& options) {
  HandDrive drive;
  const auto calibration = NumericOf(model, "grip_torque_per_force");
  if (!calibration.empty()) drive.torque_per_force_Nm_N = calibration[0];
  const auto backlash = NumericOf(model, "gear_backlash");
  drive.backlash_rad = backlash.empty() ? std::numeric_limits<double>::infinity() : backlash[0];
  if (mjcf::HasMotors(model)) {
    drive.stall_speed_rad_s = kStallShare / kClosing_s;
  } else {
    drive.damping_Nm_s = std::max(0.0, -model->actuator_biasprm[MotorOf(model) * mjNBIAS + 2]);
  }
  const auto force = NumericOf(model, "grip_force");
  if (force.size() == 2) {
    drive.first_force_N = force[0];
    drive.max_force_N = force[1];
  } else if (!force.empty()) {
    throw base::InputError(
        "numeric \"grip_force\" must have two values: the first and the maximum grip force [N]");
  }
  drive.max_force_N = options.max_force_N.value_or(drive.max_force_N);
  drive.first_force_N =
      std::min(options.initial_force_N.value_or(drive.first_force_N), drive.max_force_N);
  return drive;
}

// Speeds of a hand with "hand_motors" are shares of its travel, scaled like those of a geared one.
HandControlOptions OptionsOf(const mjModel* model, HandControlOptions options) {
  if (mjcf::HasMotors(model)) {
    options.closing_speed_rad_s /= HandControlOptions().closing_speed_rad_s * kClosing_s;
  }
  return options;
}

}  // namespace

void GripControl::Preshape(double from_rad, double to_rad) {
  mode_ = Mode::kPreshape;
  target_rad_ = to_rad;
  commanded_rad_ = from_rad;
}

void GripControl::Close(bool firm) {
  mode_ = Mode::kClosing;
  first_force_N_ = firm ? drive_.max_force_N : drive_.first_force_N;
  stalled_s_ = 0.0;
  force_N_ = 0.0;
}

void GripControl::Open() {
  mode_ = Mode::kOpening;
  force_N_ = 0.0;
}

bool GripControl::Gripping() const {
  return mode_ == Mode::kGripping && gripping_s_ >= kFirstGripHold_s;
}

double GripControl::Tick(const HandReading& reading) {
  const double step_rad = options_.closing_speed_rad_s * timestep_s_;
  switch (mode_) {
    case Mode::kPreshape:
      commanded_rad_ += std::clamp(target_rad_ - commanded_rad_, -step_rad, step_rad);
      return std::max(kLeastPositionGain_Nm_rad, kPositionRate_1_s * drive_.damping_Nm_s) *
             (commanded_rad_ - reading.angle_rad);
    case Mode::kClosing:
      return TickClosing(reading);
    case Mode::kGripping:
      return TickGripping(reading);
    case Mode::kOpening:
      break;
  }
  return -MovingTorque(-reading.speed_rad_s);
}

// A moving hand pushes what it meets with the weakest grip, not with the motor's full force.
double GripControl::moving_force_N() const {
  return std::min(options_.min_force_N, drive_.first_force_N);
}

// The motor runs free at the closing speed and stalls at the current limit.
double GripControl::MovingTorque(double speed_rad_s) const {
  const double limit_Nm = moving_force_N() * drive_.torque_per_force_Nm_N;
  const double free_Nm = drive_.damping_Nm_s * options_.closing_speed_rad_s;
  return std::min(limit_Nm + drive_.damping_Nm_s * std::max(0.0, speed_rad_s),
                  std::max(limit_Nm, free_Nm));
}

double GripControl::TickClosing(const HandReading& reading) {
  const bool both_sides = reading.thumb_N > kFelt_N && reading.fingers_N > kFelt_N;
  if (both_sides || Stalls(reading.speed_rad_s)) {
    mode_ = Mode::kGripping;
    force_N_ = std::min(first_force_N_, moving_force_N());
    gripping_s_ = since_slip_s_ = unloaded_s_ = 0.0;
  }
  return MovingTorque(reading.speed_rad_s);
}

bool GripControl::Stalls(double speed_rad_s) {
  stalled_s_ = std::abs(speed_rad_s) < drive_.stall_speed_rad_s ? stalled_s_ + timestep_s_ : 0.0;
  return stalled_s_ > kStallTime_s;
}

bool GripControl::HearsSlip(const HandReading& reading) {
  gripping_s_ += timestep_s_;
  since_slip_s_ += timestep_s_;
  if (!options_.slip_control || !reading.slips || !Gripping()) return false;
  if (since_slip_s_ < kSlipPeriod_s) return false;
  since_slip_s_ = unloaded_s_ = 0.0;
  slipped_along_H_ = reading.load_H.normalized();
  ++slips_heard_;
  return true;
}

bool GripControl::LoadIsGone(const HandReading& reading) {
  const bool draws = reading.slips || reading.load_H.dot(slipped_along_H_) > kNoLoad_N;
  unloaded_s_ = draws ? 0.0 : unloaded_s_ + timestep_s_;
  return unloaded_s_ > kLoadGone_s;
}

double GripControl::TickGripping(const HandReading& reading) {
  const double step_N = kForceRate_N_s * timestep_s_;
  if (force_N_ < first_force_N_) {
    force_N_ = std::min(first_force_N_, force_N_ + step_N);
  } else if (HearsSlip(reading)) {
    force_N_ += options_.slip_gain_N;
  } else if (LoadIsGone(reading)) {
    force_N_ = std::max(first_force_N_, force_N_ - step_N);
  }
  force_N_ = std::min(force_N_, drive_.max_force_N);
  return force_N_ * drive_.torque_per_force_Nm_N;
}

double Ratchet(double lower_rad, double upper_rad, double angle_rad, double backlash_rad) {
  return std::max(lower_rad, std::min(angle_rad - backlash_rad, upper_rad));
}

HandMotors::HandMotors(mjModel* model, double strongest_N)
    : model_(model), motors_(mjcf::HandMotors(model)), tool_(mjcf::Find(model, mjOBJ_SITE, "tcp")) {
  CallEngine(nullptr, [&] { closing_ = mjcf::CloseOnNothing(model); });
  DataPtr scratch(mj_makeData(model));
  for (const mjcf::HandMotor& motor : motors_) drives_.push_back({motor, {}, 0.0, 0.0, 0.0});
  for (int i = 0; i < kSamples; ++i) {
    const double share = closing_.Touching() * i / (kSamples - 1);
    closing_.Pose(model, scratch.get(), share);
    CallEngine(nullptr, [&] { mj_forward(model, scratch.get()); });
    const auto forces = mjcf::GripForces(model, scratch.get(), motors_, closing_, share,
                                         SitePose(scratch.get(), tool_).linear().col(0));
    for (std::size_t k = 0; k < drives_.size(); ++k) {
      drives_[k].per_newton = std::max(drives_[k].per_newton, std::abs(forces[k]));
    }
  }
  // Motors that move the fingers together become equal servos, by the work of the one that does
  // most.
  double work = 0.0;
  for (const Drive& drive : drives_) {
    const double of_drive = drive.per_newton * std::abs(drive.motor.Travel());
    work = std::max(work, of_drive);
    work_per_newton_m_ += of_drive;
  }
  for (Drive& drive : drives_) {
    if (drive.motor.Moves()) drive.per_newton = work / std::abs(drive.motor.Travel());
    ServePlainMotor(drive, strongest_N);
  }
}

// A plain motor's controller gives it stiffness and damping; the damping uses the engine's own
// implicit terms.
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
  return Along([&](const Drive& drive) { return At(drive, data) - drive.motor.open; });
}

double HandMotors::Speed(const mjData* data) const {
  return Along(
      [&](const Drive& drive) { return mjcf::DriveSpeed(model_, data, drive.motor.actuator); });
}

double HandMotors::Wanted(const Drive& drive, const mjData* data, double share) const {
  const double goal = drive.motor.open + share * drive.motor.Travel();
  return drive.stiffness * (goal - At(drive, data));
}

void HandMotors::Follow(mjData* data, double share) const {
  for (const Drive& drive : drives_) Command(data, drive, Wanted(drive, data, share));
}

// Force that a drive loses to its own damping and to that of the joints that it moves.
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
  double work_J = -force_N * work_per_newton_m_;  // beyond the limit, over the full travel
  double stiffness_J = 0.0;
  for (const Drive& drive : drives_) {
    const double way = drive.motor.Travel();
    work_J += way * Wanted(drive, data, share) - std::abs(way) * Damping(drive, data);
    stiffness_J += way * way * drive.stiffness;
  }
  Follow(data, share - std::max(0.0, work_J) / stiffness_J);
}

void HandMotors::BeginGrip(const mjData* data) {
  held_share_ = Share(data);
  for (Drive& drive : drives_) drive.held = At(drive, data);
}

void HandMotors::Grip(mjData* data, double force_N) const {
  const double share = Share(data);
  const auto forces = mjcf::GripForces(model_, data, motors_, closing_, share,
                                       SitePose(data, tool_).linear().col(0));
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    const Drive& drive = drives_[k];
    const double shape = drive.held + (share - held_share_) * drive.motor.Travel();
    Command(data, drive, forces[k] * force_N + drive.stiffness * (shape - At(drive, data)));
  }
}

void HandMotors::Command(mjData* data, const Drive& drive, double force) const {
  const mjcf::AffineDrive& affine = drive.affine;
  data->ctrl[model_->actuator_ctrladr[drive.motor.actuator]] =
      (force - affine.bias[0] - affine.bias[1] * At(drive, data)) / affine.gain;
}

HandController::HandController(World& world, const HandGeoms& hand,
                               const HandControlOptions& options)
    : world_(&world),
      hand_(&hand),
      drive_(DriveOf(world.model(), options)),
      options_(OptionsOf(world.model(), options)),
      control_(options_, drive_, world.physics().timestep_s) {
  mjModel* model = world.model();
  if (mjcf::HasMotors(model)) {
    motors_.emplace(model, drive_.max_force_N);
  } else {
    joints_ = TupleOf(model, mjOBJ_JOINT, "hand_joints");
    motor_ = MotorOf(model);
  }
  for (const int joint : joints_) open_limit_.push_back(model->jnt_range[2 * joint]);
  target_angle_ = set_share_ = Angle();
  control_.Preshape(target_angle_, target_angle_);
}

double HandController::ClosedEnd() const {
  return motors_ ? 1.0 : world_->model()->jnt_range[2 * joints_[0] + 1];
}

double HandController::MeanOf(const mjtNum* values, const int* address) const {
  double sum = 0.0;
  for (const int joint : joints_) sum += values[address[joint]];
  return sum / static_cast<double>(joints_.size());
}

double HandController::Angle() const {
  const mjData* data = world_->data();
  return motors_ ? motors_->Share(data) : MeanOf(data->qpos, world_->model()->jnt_qposadr);
}

double HandController::Speed() const {
  const mjData* data = world_->data();
  return motors_ ? motors_->Speed(data) : MeanOf(data->qvel, world_->model()->jnt_dofadr);
}

// The most closed angle whose gap is at least gap_m, found on a copy of the kinematics.
double HandController::AngleOfGap(double gap_m, int halvings) const {
  if (motors_) return motors_->closing().ShareAtGap(gap_m);
  const mjModel* model = world_->model();
  double best = open_limit_[0];
  const double upper = ClosedEnd();
  const DataPtr scratch = MakeData(model);
  const auto is_open = [&](double angle) {
    for (const int joint : joints_) scratch->qpos[model->jnt_qposadr[joint]] = angle;
    CallEngine(nullptr, [&] { mj_kinematics(model, scratch.get()); });
    return hand_->Gap(model, scratch.get()) >= gap_m;
  };
  for (int i = 0; i <= kGapSteps; ++i) {
    const double angle = open_limit_[0] + (upper - open_limit_[0]) * i / kGapSteps;
    if (!is_open(angle)) break;
    best = angle;
  }
  double step = (upper - open_limit_[0]) / kGapSteps;
  for (int i = 0; i < halvings && best < upper; ++i) {
    step *= 0.5;
    if (is_open(best + step)) best += step;
  }
  return best;
}

void HandController::Preshape(double gap_m) {
  target_angle_ = AngleOfGap(gap_m);
  control_.Preshape(Angle(), target_angle_);
}

void HandController::Open() {
  control_.Open();
  set_share_ = Angle();
  for (std::size_t i = 0; i < joints_.size(); ++i)
    world_->model()->jnt_range[2 * joints_[i]] = open_limit_[i];
}

void HandController::FeelPressure(HandReading& reading) const {
  const mjModel* model = world_->model();
  for (const int sensor : hand_->touch_sensors()) {
    const int body = model->site_bodyid[model->sensor_objid[sensor]];
    const double pressure_N = world_->data()->sensordata[model->sensor_adr[sensor]];
    (hand_->IsThumbBody(body) ? reading.thumb_N : reading.fingers_N) += pressure_N;
  }
}

double HandController::FeltForce() const {
  HandReading reading;
  FeelPressure(reading);
  return std::min(reading.thumb_N, reading.fingers_N);
}

void HandController::RatchetJoints() {
  mjModel* model = world_->model();
  for (const int joint : joints_) {
    double* range = model->jnt_range + 2 * joint;
    range[0] = Ratchet(range[0], range[1], world_->data()->qpos[model->jnt_qposadr[joint]],
                       drive_.backlash_rad);
  }
}

void HandController::Tick(bool slips, const Eigen::Vector3d& load_W) {
  const base::Pose X_WH = BodyPose(world_->data(), hand_->body());
  HandReading reading{Angle(), Speed(), 0.0, 0.0, slips, X_WH.linear().transpose() * load_W};
  FeelPressure(reading);
  const bool gripped = control_.mode() == GripControl::Mode::kGripping;
  const double torque_Nm = control_.Tick(reading);
  if (motors_) {
    if (!gripped && control_.mode() == GripControl::Mode::kGripping) {
      motors_->BeginGrip(world_->data());
    }
    DriveMotors();
    return;
  }
  world_->data()->ctrl[motor_] = torque_Nm;
  if (control_.Ratchets()) RatchetJoints();
}

// The commanded share of closing moves at the closing speed, whatever the motors meet.
void HandController::DriveMotors() {
  mjData* data = world_->data();
  const double step = world_->physics().timestep_s * options_.closing_speed_rad_s;
  switch (control_.mode()) {
    case GripControl::Mode::kPreshape:
      set_share_ = control_.commanded_rad();
      return motors_->Follow(data, set_share_);
    case GripControl::Mode::kClosing:
      set_share_ = std::min(1.0, set_share_ + step);
      return motors_->Press(data, set_share_, control_.moving_force_N());
    case GripControl::Mode::kGripping:
      return motors_->Grip(data, control_.force_N());
    case GripControl::Mode::kOpening:
      set_share_ = std::max(0.0, set_share_ - step);
      return motors_->Follow(data, set_share_);
  }
}

bool HandController::Preshaped() const { return std::abs(Angle() - target_angle_) < kAtTarget_rad; }
double HandController::Aperture() const { return ClosedEnd() - Angle(); }
bool HandController::FullyClosed() const { return Aperture() < kAtClosedEnd_rad; }

bool HandController::FeelsEmpty() {
  if (!empty_angle_) empty_angle_ = AngleOfGap(kLeastFelt_m, kGapHalvings);
  return Angle() > *empty_angle_;
}
bool HandController::FullyOpen() const {
  return Angle() < (motors_ ? 0.0 : open_limit_[0]) + kAtTarget_rad;
}

}  // namespace rangegrasp::sim::internal
