#include "sim/internal/hand_controller.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "sim/internal/engine.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim::internal {
namespace {

constexpr double kTorquePerForce =
    0.135;  // Nm at the motor for a newton between the tips, if the model does not say
constexpr double kSpeedDamping = 0.61;   // Nm s/rad, likewise
constexpr double kBacklash_rad = 0.008;  // of the gear, likewise
constexpr double kPositionGain = 15.0;   // Nm/rad, of the pre-shape
constexpr double kFelt_N = 0.5;          // least pressure that a side feels
constexpr double kStallSpeed_rad_s = 0.03;
constexpr double kStallTime_s = 0.06;
constexpr double kForceRate_N_s = 250.0;
constexpr double kFirstGripHold_s = 0.05;
constexpr double kSlipPeriod_s = 0.04;  // one detection of slip at most in this time
constexpr int kGapSamples = 60;

}  // namespace

void Glove::Tick(mjModel* model, const mjData* data) {
  std::vector<double> speed(hand_->all().size(), -1.0);
  std::vector<int> slot(static_cast<std::size_t>(model->ngeom), -1);
  for (std::size_t i = 0; i < hand_->all().size(); ++i)
    slot[static_cast<std::size_t>(hand_->all()[i])] = static_cast<int>(i);
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    for (const int geom : contact.geom) {
      if (geom < 0 || slot[static_cast<std::size_t>(geom)] < 0) continue;
      double& fastest = speed[static_cast<std::size_t>(slot[static_cast<std::size_t>(geom)])];
      fastest = std::max(fastest, SlipSpeed(model, data, contact));
    }
  }
  states_.resize(hand_->all().size());
  slides_ = false;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    states_[i].Update(speed[i]);
    model->geom_friction[3 * hand_->all()[i]] = states_[i].Coefficient(pair_);
    slides_ = slides_ || (states_[i].sliding && speed[i] >= 0.0 && hand_->IsTip(hand_->all()[i]));
  }
}

HandController::HandController(World& world, const HandGeoms& hand,
                               const HandControlOptions& options)
    : world_(&world),
      hand_(&hand),
      options_(options),
      joints_(TupleOf(world.model(), mjOBJ_JOINT, "hand_joints")),
      torque_per_force_(kTorquePerForce),
      speed_damping_(kSpeedDamping),
      backlash_rad_(kBacklash_rad) {
  const mjModel* model = world.model();
  const auto motors = TupleOf(model, mjOBJ_ACTUATOR, "hand_motor");
  if (motors.size() != 1) throw core::InputError("tuple \"hand_motor\" must hold one actuator");
  motor_ = motors[0];
  const auto calibration = NumericOf(model, "grip_torque_per_force");
  if (!calibration.empty()) torque_per_force_ = calibration[0];
  const auto backlash = NumericOf(model, "gear_backlash");
  if (!backlash.empty()) backlash_rad_ = backlash[0];
  const double damping = -model->actuator_biasprm[motor_ * mjNBIAS + 2];
  if (damping > 0.0) speed_damping_ = damping;
  for (const int joint : joints_) open_limit_.push_back(model->jnt_range[2 * joint]);
  commanded_angle_ = target_angle_ = Angle();
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
double HandController::AngleOfGap(double gap_m) const {
  const mjModel* model = world_->model();
  mjData* scratch = nullptr;
  double best = open_limit_[0];
  const double upper = model->jnt_range[2 * joints_[0] + 1];
  CallEngine(nullptr, [&] { scratch = mj_makeData(model); });
  const DataPtr owner(scratch);
  for (int i = 0; i <= kGapSamples; ++i) {
    const double angle = open_limit_[0] + (upper - open_limit_[0]) * i / kGapSamples;
    for (const int joint : joints_) scratch->qpos[model->jnt_qposadr[joint]] = angle;
    CallEngine(nullptr, [&] { mj_kinematics(model, scratch); });
    if (hand_->Gap(model, scratch) < gap_m) break;
    best = angle;
  }
  return best;
}

void HandController::Preshape(double gap_m) {
  mode_ = Mode::kPreshape;
  target_angle_ = AngleOfGap(gap_m);
  commanded_angle_ = Angle();
}

void HandController::Close() {
  mode_ = Mode::kClosing;
  stalled_s_ = 0.0;
  force_N_ = 0.0;
}

void HandController::Open() {
  mode_ = Mode::kOpening;
  force_N_ = 0.0;
  for (std::size_t i = 0; i < joints_.size(); ++i)
    world_->model()->jnt_range[2 * joints_[i]] = open_limit_[i];
}

bool HandController::FeelsBothSides() const {
  const mjData* data = world_->data();
  double thumb = 0.0;
  double fingers = 0.0;
  for (int i = 0; i < data->ncon; ++i) {
    for (const int geom : data->contact[i].geom) {
      if (geom < 0 || !hand_->IsTip(geom)) continue;
      (hand_->IsThumb(geom) ? thumb : fingers) += NormalForce(world_->model(), data, i);
    }
  }
  return thumb > kFelt_N && fingers > kFelt_N;
}

bool HandController::Stalls() {
  stalled_s_ =
      std::abs(Speed()) < kStallSpeed_rad_s ? stalled_s_ + world_->physics().timestep_s : 0.0;
  return stalled_s_ > kStallTime_s;
}

void HandController::Drive(double torque_Nm) { world_->data()->ctrl[motor_] = torque_Nm; }

void HandController::Ratchet() {
  mjModel* model = world_->model();
  for (const int joint : joints_) {
    const double angle = world_->data()->qpos[model->jnt_qposadr[joint]];
    double* range = model->jnt_range + 2 * joint;
    range[0] = std::max(range[0], std::min(angle - backlash_rad_, range[1]));
  }
}

void HandController::TickClosing() {
  const double torque = speed_damping_ * options_.closing_speed_rad_s;
  Drive(torque);
  if (!FeelsBothSides() && !Stalls()) return;
  mode_ = Mode::kGripping;
  force_N_ = std::min(options_.initial_force_N, torque / torque_per_force_);
  gripping_s_ = since_slip_s_ = 0.0;
}

void HandController::TickGripping(bool slides) {
  const double dt = world_->physics().timestep_s;
  if (force_N_ < options_.initial_force_N) {
    force_N_ = std::min(options_.initial_force_N, force_N_ + kForceRate_N_s * dt);
  } else {
    gripping_s_ += dt;
    since_slip_s_ += dt;
    if (options_.slip_control && slides && Gripping() && since_slip_s_ >= kSlipPeriod_s) {
      force_N_ += options_.slip_gain_N;
      since_slip_s_ = 0.0;
    }
  }
  force_N_ = std::clamp(force_N_, options_.min_force_N, options_.max_force_N);
  Drive(force_N_ * torque_per_force_);
}

void HandController::Tick(bool slides) {
  const double step = options_.closing_speed_rad_s * world_->physics().timestep_s;
  switch (mode_) {
    case Mode::kPreshape:
      commanded_angle_ += std::clamp(target_angle_ - commanded_angle_, -step, step);
      Drive(kPositionGain * (commanded_angle_ - Angle()));
      break;
    case Mode::kClosing:
      TickClosing();
      Ratchet();
      break;
    case Mode::kGripping:
      TickGripping(slides);
      Ratchet();
      break;
    case Mode::kOpening:
      Drive(-speed_damping_ * options_.closing_speed_rad_s);
      break;
  }
}

bool HandController::Preshaped() const { return std::abs(Angle() - target_angle_) < 0.02; }
bool HandController::Gripping() const {
  return mode_ == Mode::kGripping && gripping_s_ >= kFirstGripHold_s;
}
bool HandController::FullyClosed() const {
  return Angle() > world_->model()->jnt_range[2 * joints_[0] + 1] - 0.01;
}
bool HandController::FullyOpen() const { return Angle() < open_limit_[0] + 0.02; }

}  // namespace rangegrasp::sim::internal
