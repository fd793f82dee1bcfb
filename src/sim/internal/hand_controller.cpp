#include "sim/internal/hand_controller.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "sim/internal/engine.h"
#include "sim/internal/kinematics.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim::internal {
namespace {

// The hand's range is tried in so many steps for a gap: 0.7 deg or 1.7 mm of gap each.
constexpr int kGapSteps = 60;
// A joint is where it should be within this: 3 mm of gap, twice what the passive fingers' springs
// move it by.
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
  if (motors.size() != 1) throw core::InputError("tuple \"hand_motor\" must hold one actuator");
  return motors[0];
}

// The scene's own where it says them; forces that the options state go before it.
HandDrive DriveOf(const mjModel* model, int motor, const HandControlOptions& options) {
  HandDrive drive;
  const auto calibration = NumericOf(model, "grip_torque_per_force");
  if (!calibration.empty()) drive.torque_per_force_Nm_N = calibration[0];
  const auto backlash = NumericOf(model, "gear_backlash");
  if (!backlash.empty()) drive.backlash_rad = backlash[0];
  drive.damping_Nm_s = std::max(0.0, -model->actuator_biasprm[motor * mjNBIAS + 2]);
  const auto force = NumericOf(model, "grip_force");
  if (!force.empty() && force.size() != 2) {
    throw core::InputError(
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

}  // namespace

HandController::HandController(World& world, const HandGeoms& hand,
                               const HandControlOptions& options)
    : world_(&world),
      hand_(&hand),
      joints_(TupleOf(world.model(), mjOBJ_JOINT, "hand_joints")),
      motor_(MotorOf(world.model())),
      drive_(DriveOf(world.model(), motor_, options)),
      control_(options, drive_, world.physics().timestep_s) {
  for (const int joint : joints_) open_limit_.push_back(world.model()->jnt_range[2 * joint]);
  target_angle_ = Angle();
  control_.Preshape(target_angle_, target_angle_);
}

double HandController::Angle() const {
  double sum = 0.0;
  for (const int joint : joints_) sum += world_->data()->qpos[world_->model()->jnt_qposadr[joint]];
  return sum / static_cast<double>(joints_.size());
}

double HandController::Speed() const {
  double sum = 0.0;
  for (const int joint : joints_) sum += world_->data()->qvel[world_->model()->jnt_dofadr[joint]];
  return sum / static_cast<double>(joints_.size());
}

// The most closed angle whose gap is at least gap_m, found on a copy of the kinematics.
double HandController::AngleOfGap(double gap_m, int halvings) const {
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
  world_->data()->ctrl[motor_] = control_.Tick(reading);
  if (control_.Ratchets()) RatchetJoints();
}

bool HandController::Preshaped() const { return std::abs(Angle() - target_angle_) < kAtTarget_rad; }
double HandController::Aperture() const {
  return world_->model()->jnt_range[2 * joints_[0] + 1] - Angle();
}
bool HandController::FullyClosed() const { return Aperture() < kAtClosedEnd_rad; }

bool HandController::FeelsEmpty() {
  if (!empty_angle_) empty_angle_ = AngleOfGap(kLeastFelt_m, kGapHalvings);
  return Angle() > *empty_angle_;
}
bool HandController::FullyOpen() const { return Angle() < open_limit_[0] + kAtTarget_rad; }

}  // namespace rangegrasp::sim::internal
