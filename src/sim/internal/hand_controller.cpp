#include "sim/internal/hand_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "sim/internal/engine.h"
#include "sim/internal/kinematics.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim::internal {
namespace {

// The hand's range is tried in so many steps for a gap: 0.7 deg or 1.7 mm of gap each.
constexpr int kGapSteps = 60;
// A joint is where it should be within this: 3 mm of gap, twice what the passive fingers' springs
// move it by; of a hand with "hand_motors" 2 % of its way.
constexpr double kAtTarget_rad = 0.02;
// A gap of the tips that a closed hand's joints tell from none: what it closes on is thicker (the
// bowl's wall: 3 mm, and the glove gives less than that). Closed on nothing the joints stop at up
// to 1.1 mm, the passive fingers' springs being in between.
constexpr double kLeastFelt_m = 0.002;
// Halvings of one of the steps above: 0.03 mm of gap.
constexpr int kGapHalvings = 6;
// And at the closed end of its range within this: 1.4 mm of gap, nothing to be held there.
constexpr double kAtClosedEnd_rad = 0.01;

int MotorOf(const mjModel* model) {
  const auto motors = TupleOf(model, mjOBJ_ACTUATOR, "hand_motor");
  if (motors.size() != 1) throw base::InputError("tuple \"hand_motor\" must hold one actuator");
  return motors[0];
}

// A hand with "hand_motors" closes its whole way in this time (a Robotiq 2F-85: 0.57 s).
constexpr double kClosing_s = 0.5;
// The share of its closing speed below which a motor stalls, as of the geared one.
constexpr double kStallShare = 0.03 / 2.2;

// The scene's own where it says them; forces that the options state go before it.
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
  if (!force.empty() && force.size() != 2) {
    throw base::InputError(
        "numeric \"grip_force\" must hold two values: the first grip and the strongest one [N]");
  }
  if (!force.empty()) {
    drive.first_force_N = force[0];
    drive.max_force_N = force[1];
  }
  drive.max_force_N = options.max_force_N.value_or(drive.max_force_N);
  drive.first_force_N =
      std::min(options.initial_force_N.value_or(drive.first_force_N), drive.max_force_N);
  return drive;
}

// Speeds of a hand with "hand_motors" are shares of its way: faster and slower as a geared one.
HandControlOptions OptionsOf(const mjModel* model, HandControlOptions options) {
  if (mjcf::HasMotors(model)) {
    options.closing_speed_rad_s /= HandControlOptions().closing_speed_rad_s * kClosing_s;
  }
  return options;
}

}  // namespace

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

double HandController::Angle() const {
  if (motors_) return motors_->Share(world_->data());
  double sum = 0.0;
  for (const int joint : joints_) sum += world_->data()->qpos[world_->model()->jnt_qposadr[joint]];
  return sum / static_cast<double>(joints_.size());
}

double HandController::Speed() const {
  if (motors_) return motors_->Speed(world_->data());
  double sum = 0.0;
  for (const int joint : joints_) sum += world_->data()->qvel[world_->model()->jnt_dofadr[joint]];
  return sum / static_cast<double>(joints_.size());
}

// The most closed angle whose gap is at least gap_m, found on a copy of the kinematics.
double HandController::AngleOfGap(double gap_m, int halvings) const {
  if (motors_) return motors_->closing().ShareAtGap(gap_m);
  const mjModel* model = world_->model();
  mjData* scratch = nullptr;
  double best = open_limit_[0];
  const double upper = model->jnt_range[2 * joints_[0] + 1];
  CallEngine(nullptr, [&] { scratch = mj_makeData(model); });
  const DataPtr owner(scratch);
  const auto is_open = [&](double angle) {
    for (const int joint : joints_) scratch->qpos[model->jnt_qposadr[joint]] = angle;
    CallEngine(nullptr, [&] { mj_kinematics(model, scratch); });
    return hand_->Gap(model, scratch) >= gap_m;
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

std::vector<Eigen::Vector3d> HandController::PressedPads(double least_N) const {
  const mjModel* model = world_->model();
  const mjData* data = world_->data();
  std::vector<Eigen::Vector3d> pads_W;
  for (const int sensor : hand_->touch_sensors()) {
    if (data->sensordata[model->sensor_adr[sensor]] <= least_N) continue;
    pads_W.push_back(Vec3(data->site_xpos + 3 * model->sensor_objid[sensor]));
  }
  return pads_W;
}

void HandController::RatchetJoints() {
  mjModel* model = world_->model();
  for (const int joint : joints_) {
    double* range = model->jnt_range + 2 * joint;
    range[0] = Ratchet(range[0], range[1], world_->data()->qpos[model->jnt_qposadr[joint]],
                       drive_.backlash_rad);
  }
}

void HandController::Tick(bool slips) {
  HandReading reading{Angle(), Speed(), 0.0, 0.0, slips};
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

// The share that motors are sent to goes at the closing speed, whatever they meet: they press with
// no more than what a moving hand may shove with, or the grip's force.
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
bool HandController::FullyOpen() const { return Angle() < OpenEnd() + kAtTarget_rad; }

}  // namespace rangegrasp::sim::internal
