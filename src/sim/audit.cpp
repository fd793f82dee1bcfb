#include "sim/internal/audit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace rangegrasp::sim::internal {
namespace {

double EqualityError(const mjData* data) {
  double error = 0.0;
  for (int row = 0; row < data->ne; ++row) error = std::max(error, std::abs(data->efc_pos[row]));
  return error;
}

double Percentile95(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

void Judge(const char* figure, double value, double bound, std::string& failed) {
  if (!failed.empty() || value <= bound) return;
  char text[160];
  std::snprintf(text, sizeof(text), "%s %.4g > %.4g", figure, value, bound);
  failed = text;
}

}  // namespace

core::Pose PoseInHand(const World& world, const HandGeoms& hand, int target) {
  const mjData* data = world.data();
  const core::Pose X_WH = core::MakePose(
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * hand.body()),
      Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * hand.body()));
  // Both from the last kinematics, which lags the state by one step: the same instant for both.
  const int body = world.object_body(target);
  const core::Pose X_WO = core::MakePose(
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body),
      Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * body));
  return X_WH.inverse() * X_WO;
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
  mjtNum v[6];
  mj_objectVelocity(model, data, mjOBJ_BODY, body, v,
                    1);  // rotation, then translation, in the inertial frame
  const double mass = model->body_mass[body];
  const mjtNum* inertia = model->body_inertia + 3 * body;
  double energy = 0.5 * mass * (v[3] * v[3] + v[4] * v[4] + v[5] * v[5]);
  for (int k = 0; k < 3; ++k) energy += 0.5 * inertia[k] * v[k] * v[k];
  return energy - mass * mju_dot3(model->opt.gravity, data->xipos + 3 * body);
}

void AuditRecorder::Step(bool holding) {
  audit_.torque_ratio =
      std::max(audit_.torque_ratio, servo_->TorqueRatio(world_->model(), world_->data()));
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
                            bool held_after_carry) {
  if (!penetration_.empty()) {
    audit_.penetration_p95_m = Percentile95(penetration_);
    audit_.penetration_max_m = *std::max_element(penetration_.begin(), penetration_.end());
  }
  audit_.warnings = world_->WarningCount() - warnings_before_;
  std::string& failed = audit_.failed;
  if (audit_.warnings > 0) failed = "engine warnings: " + world_->Warnings();
  Judge("torque_ratio", audit_.torque_ratio, bounds.torque_ratio, failed);
  if (!held_after_lift) return audit_;
  Judge("penetration_p95_m", audit_.penetration_p95_m, bounds.penetration_p95_m, failed);
  Judge("penetration_max_m", audit_.penetration_max_m, bounds.penetration_max_m, failed);
  Judge("equality_error_rad", audit_.equality_error_rad, bounds.equality_error_rad, failed);
  Judge("energy_gain_J", audit_.energy_gain_J, bounds.energy_gain_J, failed);
  if (!held_after_carry || slid_at_rest_) return audit_;
  Judge("creep_m_s", audit_.creep_m_s, bounds.creep_m_s, failed);
  Judge("creep_rad_s", audit_.creep_rad_s, bounds.creep_rad_s, failed);
  return audit_;
}

}  // namespace rangegrasp::sim::internal
