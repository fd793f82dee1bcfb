#include "sim/internal/audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/quantile.h"
#include "sim/internal/kinematics.h"

namespace rangegrasp::sim::internal {
namespace {

double EqualityError(const mjData* data) {
  double error = 0.0;
  for (int row = 0; row < data->ne; ++row) error = std::max(error, std::abs(data->efc_pos[row]));
  return error;
}

constexpr double kPercentile = 0.95;  // of penetration_p95_m
// A drive is at its limit from this share of it on: the engine cuts its torque there, so that it
// never exceeds it.
constexpr double kAtLimit = 1.0 - 1e-9;

// Names the first figure that is out of bounds; one that is no number is.
void Check(const char* figure, double value, double bound, std::string& failed) {
  if (!failed.empty() || value <= bound) return;
  failed = fmt::format("{} {:.4g} > {:.4g}", figure, value, bound);
}

}  // namespace

core::Pose PoseInHand(const World& world, const HandGeoms& hand, int target) {
  // Both from the last kinematics, which lags the state by one step: the same instant for both.
  const core::Pose X_WH = BodyPose(world.data(), hand.body());
  return X_WH.inverse() * BodyPose(world.data(), world.object_body(target));
}

AuditRecorder::AuditRecorder(const World& world, const HandGeoms& hand, const ArmServo& servo,
                             int target)
    : world_(&world),
      hand_(&hand),
      servo_(&servo),
      target_(target),
      warnings_before_(world.WarningCount()) {}

double AuditRecorder::Energy() const {
  const mjModel* model = world_->model();
  const mjData* data = world_->data();
  const int body = world_->object_body(target_);
  mjtNum v[6];  // rotation, then translation, in the inertial frame
  mj_objectVelocity(model, data, mjOBJ_BODY, body, v, /*flg_local=*/1);
  const double mass = model->body_mass[body];
  const mjtNum* inertia = model->body_inertia + 3 * body;
  double energy = 0.5 * mass * (v[3] * v[3] + v[4] * v[4] + v[5] * v[5]);
  for (int k = 0; k < 3; ++k) energy += 0.5 * inertia[k] * v[k] * v[k];
  return energy - mass * mju_dot3(model->opt.gravity, data->xipos + 3 * body);
}

void AuditRecorder::Step(bool holding) {
  const double torque_ratio = servo_->TorqueRatio(world_->model(), world_->data());
  audit_.torque_ratio = std::max(audit_.torque_ratio, torque_ratio);
  if (torque_ratio >= kAtLimit) audit_.torque_limit_s += world_->physics().timestep_s;
  if (!holding) return;
  audit_.equality_error_rad = std::max(audit_.equality_error_rad, EqualityError(world_->data()));
  const Touch touch =
      TouchOf(world_->model(), world_->data(), *hand_, world_->object_body(target_));
  if (touch.hand) penetration_.push_back(touch.deepest_m);
}

void AuditRecorder::BeginRest() {
  rest_pose_ = PoseInHand(*world_, *hand_, target_);
  rest_start_s_ = world_->time_s();
  rest_energy_ = Energy();
  slid_at_rest_ = false;
}

void AuditRecorder::RestStep(bool slides) {
  slid_at_rest_ = slid_at_rest_ || slides;
  audit_.energy_gain_J = std::max(audit_.energy_gain_J, Energy() - rest_energy_);
}

void AuditRecorder::EndRest() {
  const core::Pose X = PoseInHand(*world_, *hand_, target_);
  const double rest_s = world_->time_s() - rest_start_s_;
  if (rest_s <= 0.0) return;
  audit_.creep_m_s = (X.translation() - rest_pose_.translation()).norm() / rest_s;
  audit_.creep_rad_s =
      Eigen::AngleAxisd(rest_pose_.linear().transpose() * X.linear()).angle() / rest_s;
}

Audit AuditRecorder::Finish(const AuditBounds& bounds, bool held_after_lift,
                            bool held_after_carry) const {
  Audit audit = audit_;
  if (!penetration_.empty()) {
    audit.penetration_p95_m = core::QuantileOf(penetration_, kPercentile);
    audit.penetration_max_m = *std::max_element(penetration_.begin(), penetration_.end());
  }
  audit.warnings = world_->WarningCount() - warnings_before_;
  std::string& failed = audit.failed;
  if (audit.warnings > 0) failed = "engine warnings: " + world_->Warnings();
  Check("torque_ratio", audit.torque_ratio, bounds.torque_ratio, failed);
  if (!held_after_lift) return audit;
  Check("penetration_p95_m", audit.penetration_p95_m, bounds.penetration_p95_m, failed);
  Check("penetration_max_m", audit.penetration_max_m, bounds.penetration_max_m, failed);
  Check("equality_error_rad", audit.equality_error_rad, bounds.equality_error_rad, failed);
  Check("energy_gain_J", audit.energy_gain_J, bounds.energy_gain_J, failed);
  if (!held_after_carry || slid_at_rest_) return audit;
  Check("creep_m_s", audit.creep_m_s, bounds.creep_m_s, failed);
  Check("creep_rad_s", audit.creep_rad_s, bounds.creep_rad_s, failed);
  return audit;
}

}  // namespace rangegrasp::sim::internal
