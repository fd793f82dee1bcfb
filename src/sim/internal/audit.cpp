#include "sim/internal/audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "base/units.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim::internal {
namespace {

// Lever of points that an equality connects: their error as a share of it corresponds to a joint's
// error as a share of its range.
constexpr double kLever_m = 0.1;
// A joint is at an end of its range within half a degree, or 5 mm for a slide.
constexpr double kNearEnd_rad = 0.0087;
constexpr double kNearEnd_m = 0.005;
constexpr double kPercentile = 0.95;  // for penetration_p95_m

// The reference of each equality's error, before a ratchet narrows the ranges.
std::vector<double> LeversOf(const mjModel* model) {
  std::vector<double> levers(model->neq, kLever_m);
  for (int i = 0; i < model->neq; ++i) {
    if (model->eq_type[i] != mjEQ_JOINT) continue;
    const mjtNum* range = model->jnt_range + 2 * model->eq_obj1id[i];
    if (range[1] > range[0]) levers[i] = range[1] - range[0];
  }
  return levers;
}

double EqualityShare(const mjData* data, const std::vector<double>& levers) {
  double share = 0.0;
  for (int row = 0; row < data->ne; ++row) {
    share = std::max(share, std::abs(data->efc_pos[row]) / levers[data->efc_id[row]]);
  }
  return share;
}

}  // namespace

base::Pose PoseInHand(const World& world, const HandGeoms& hand, int target) {
  // Both are from the last kinematics, one step behind the state: they are of the same instant.
  const base::Pose X_WH = BodyPose(world.data(), hand.body());
  return X_WH.inverse() * BodyPose(world.data(), world.object_body(target));
}

AuditRecorder::AuditRecorder(const World& world, const HandGeoms& hand, const ArmServo& servo,
                             int target)
    : world_(&world),
      hand_(&hand),
      servo_(&servo),
      target_(target),
      warnings_before_(world.WarningCount()),
      solver_before_(world.solver_counts()),
      levers_(LeversOf(world.model())),
      at_limit_(servo.joints().size(), 0) {}

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

void AuditRecorder::LookAtJoints() {
  const mjModel* model = world_->model();
  bool drive_at_limit = false;
  for (std::size_t i = 0; i < at_limit_.size(); ++i) {
    const int joint = servo_->joints()[i];
    const double q = world_->data()->qpos[model->jnt_qposadr[joint]];
    const mjtNum* range = model->jnt_range + 2 * joint;
    const double near = model->jnt_type[joint] == mjJNT_SLIDE ? kNearEnd_m : kNearEnd_rad;
    const bool at_end = model->jnt_limited[joint] && (q < range[0] + near || q > range[1] - near);
    const bool at_limit = servo_->AtLimit(world_->data(), i);
    drive_at_limit = drive_at_limit || at_limit;
    if (at_end || at_limit) at_limit_[i] = 1;
  }
  if (drive_at_limit) audit_.drive_limit_s += world_->physics().timestep_s;
}

void AuditRecorder::Step(bool holding, const JointCommand* free_motion) {
  LookAtJoints();
  if (free_motion) {
    const double error_rad = servo_->Lags(world_->data(), *free_motion).maxCoeff();
    audit_.tracking_error_rad = std::max(audit_.tracking_error_rad, error_rad);
  }
  elsewhere_.push_back(DeepestElsewhere(*world_, *hand_, target_));
  if (!holding) return;
  audit_.equality_share = std::max(audit_.equality_share, EqualityShare(world_->data(), levers_));
  const Touch touch = TouchOf(*world_, *hand_, target_);
  if (touch.hand) penetration_.push_back(touch.deepest_m);
}

void AuditRecorder::BeginRest() {
  rest_pose_ = PoseInHand(*world_, *hand_, target_);
  rest_start_s_ = world_->time_s();
  rest_energy_ = Energy();
  audit_.energy_gain_J = 0.0;
  rest_contacts_.clear();
  const base::Pose X_HW = BodyPose(world_->data(), hand_->body()).inverse();
  for (const ContactPoint& contact : ContactsOf(*world_, *hand_, target_)) {
    const Eigen::Vector3d point_H = X_HW * contact.point_W;
    rest_contacts_.push_back(
        {point_H, X_HW.linear() * contact.normal_W, rest_pose_.inverse() * point_H});
  }
  thickness_m_ = Thickness();
}

double AuditRecorder::Thickness() const {
  double thickness_m = 0.0;
  for (const RestingContact& a : rest_contacts_) {
    for (const RestingContact& b : rest_contacts_) {
      thickness_m = std::max(thickness_m, std::abs(a.normal_H.dot(b.point_H - a.point_H)));
    }
  }
  return thickness_m;
}

double AuditRecorder::RestStep(bool disturbed) {
  if (disturbed) BeginRest();
  audit_.energy_gain_J = std::max(audit_.energy_gain_J, Energy() - rest_energy_);
  return world_->time_s() - rest_start_s_;
}

void AuditRecorder::EndRest(double unrest_s) {
  audit_.unrest_s = unrest_s;
  const double rest_s = world_->time_s() - rest_start_s_;
  if (rest_s <= 0.0) return;
  const base::Pose X_HO = PoseInHand(*world_, *hand_, target_);
  const Eigen::AngleAxisd turned = base::TurnOf(X_HO.linear() * rest_pose_.linear().transpose());
  audit_.creep_rad_s = turned.angle() / rest_s;
  for (const RestingContact& contact : rest_contacts_) {
    const double way_m = (X_HO * contact.point_O - contact.point_H).norm();
    audit_.creep_m_s = std::max(audit_.creep_m_s, way_m / rest_s);
    // std::max would drop a NaN.
    if (!std::isfinite(way_m)) audit_.creep_m_s = way_m;
  }
}

void AuditRecorder::RecordGrip(double felt_N, double strongest_N) {
  if (strongest_N > 0.0) audit_.grip_share = std::max(audit_.grip_share, felt_N / strongest_N);
}

Audit AuditRecorder::Finish(const AuditBounds& bounds, bool held_after_lift,
                            bool held_after_carry) const {
  Audit audit = audit_;
  const auto summarize = [](const std::vector<double>& depths_m, double& p95_m, double& max_m) {
    if (depths_m.empty()) return;
    p95_m = base::QuantileOf(depths_m, kPercentile);
    max_m = std::ranges::max(depths_m);
  };
  summarize(penetration_, audit.penetration_p95_m, audit.penetration_max_m);
  summarize(elsewhere_, audit.elsewhere_p95_m, audit.elsewhere_max_m);
  if (thickness_m_ > 0.0) audit.penetration_share = audit.penetration_max_m / thickness_m_;
  audit.warnings = world_->WarningCount() - warnings_before_;
  audit.repeated_steps = world_->solver_counts().repeated - solver_before_.repeated;
  audit.unsolved_steps = world_->solver_counts().unsolved - solver_before_.unsolved;
  if (audit.warnings > 0) {
    audit.failed = "engine warnings: " + world_->Warnings();
  } else if (audit.unsolved_steps > 0) {
    audit.failed = fmt::format("unsolved_steps {} > 0", audit.unsolved_steps);
  }
  if (!held_after_lift) return audit;
  // Reports the first figure out of bounds; a NaN is out of bounds.
  const auto check = [&](const char* figure, double value, double bound) {
    if (!audit.failed.empty() || value <= bound) return;
    audit.failed = fmt::format("{} {:.4g} > {:.4g}", figure, value, bound);
  };
  check("drive_limit_s", audit.drive_limit_s, bounds.drive_limit_s);
  check("tracking_error_rad", audit.tracking_error_rad, bounds.tracking_error_rad);
  check("penetration_p95_m", audit.penetration_p95_m, bounds.penetration_p95_m);
  check("penetration_max_m", audit.penetration_max_m, bounds.penetration_max_m);
  check("penetration_share", audit.penetration_share, bounds.penetration_share);
  check("elsewhere_p95_m", audit.elsewhere_p95_m, bounds.elsewhere_p95_m);
  check("elsewhere_max_m", audit.elsewhere_max_m, bounds.elsewhere_max_m);
  check("equality_share", audit.equality_share, bounds.equality_share);
  check("grip_share", audit.grip_share, bounds.grip_share);
  const double weight_N = world_->ObjectMass(target_) * base::kGravity;
  check("energy_gain_j", audit.energy_gain_J, bounds.energy_gain_m * weight_N);
  if (!held_after_carry) return audit;
  check("unrest_s", audit.unrest_s, bounds.unrest_s);
  check("creep_m_s", audit.creep_m_s, bounds.creep_m_s);
  check("creep_rad_s", audit.creep_rad_s, bounds.creep_rad_s);
  return audit;
}

std::vector<std::string> AuditRecorder::JointsAtLimits() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < at_limit_.size(); ++i) {
    if (!at_limit_[i]) continue;
    names.emplace_back(Suffix(mjcf::NameOf(world_->model(), mjOBJ_JOINT, servo_->joints()[i])));
  }
  return names;
}

}  // namespace rangegrasp::sim::internal
