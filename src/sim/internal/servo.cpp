#include "sim/internal/servo.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "sim/internal/engine.h"

namespace rangegrasp::sim::internal {
namespace {

using Eigen::VectorXd;

constexpr double kRounding = 1e-9;

VectorXd VelocityAt(const base::JointTrajectory& trajectory, std::size_t sample) {
  const auto& q = trajectory.positions;
  if (sample == 0 || sample + 1 >= q.size()) return VectorXd::Zero(q[0].size());
  return (q[sample + 1] - q[sample - 1]) / (2.0 * trajectory.period_s);
}

}  // namespace

JointCommand CommandAt(const base::JointTrajectory& trajectory, double time_s) {
  const auto& q = trajectory.positions;
  const double place =
      std::clamp(time_s / trajectory.period_s, 0.0, static_cast<double>(q.size() - 1));
  const auto from = static_cast<std::size_t>(place);
  const std::size_t to = std::min(from + 1, q.size() - 1);
  const double u = place - static_cast<double>(from);
  return {(1.0 - u) * q[from] + u * q[to],
          (1.0 - u) * VelocityAt(trajectory, from) + u * VelocityAt(trajectory, to)};
}

JointCommand StayAt(const VectorXd& position) {
  return {position, VectorXd::Zero(position.size())};
}

double DriveLimit(const mjModel* model, int joint, int actuator) {
  double limit = mjMAXVAL;
  if (model->jnt_actfrclimited[joint]) {
    const mjtNum* range = model->jnt_actfrcrange + 2 * joint;
    limit = std::min(range[1], -range[0]);
  }
  if (model->actuator_forcelimited[actuator]) {
    const mjtNum* range = model->actuator_forcerange + 2 * actuator;
    limit = std::min({limit, range[1], -range[0]});
  }
  return limit;
}

ArmServo::ArmServo(const mjModel* model)
    : model_(model),
      joints_(TupleOf(model, mjOBJ_JOINT, "arm_joints")),
      actuators_(TupleOf(model, mjOBJ_ACTUATOR, "arm_actuators")) {
  if (joints_.size() != actuators_.size()) {
    throw base::InputError(
        "tuples \"arm_joints\" and \"arm_actuators\" must be of the same length");
  }
}

void ArmServo::Command(mjData* data, const JointCommand& command) const {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const int actuator = actuators_[i];
    const double kp = model_->actuator_gainprm[actuator * mjNGAIN];
    const double kv = -model_->actuator_biasprm[actuator * mjNBIAS + 2];
    const double damping = model_->dof_damping[model_->jnt_dofadr[joints_[i]]];
    const double lead = kp > 0.0 ? (kv + damping) / kp * command.velocity[i] : 0.0;
    data->ctrl[actuator] = command.position[i] + lead;
  }
}

bool ArmServo::AtLimit(const mjData* data, std::size_t i) const {
  // The engine clamps the torque at this limit, so that it never exceeds it.
  const double limit = (1.0 - kRounding) * DriveLimit(model_, joints_[i], actuators_[i]);
  return std::abs(data->qfrc_actuator[model_->jnt_dofadr[joints_[i]]]) >= limit;
}

void ArmServo::GiveWay(const mjData* data, double share, VectorXd& position) const {
  const VectorXd torques = Torques(data);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double most = share * DriveLimit(model_, joints_[i], actuators_[i]);
    const double kp = model_->actuator_gainprm[actuators_[i] * mjNGAIN];
    if (kp > 0.0) position[i] -= (torques[i] - std::clamp(torques[i], -most, most)) / kp;
  }
}

VectorXd ArmServo::Torques(const mjData* data) const {
  VectorXd torques(joints_.size());
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    torques[i] = data->qfrc_actuator[model_->jnt_dofadr[joints_[i]]];
  }
  return torques;
}

VectorXd ArmServo::Lags(const mjData* data, const JointCommand& command) const {
  VectorXd lags(joints_.size());
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double ahead = command.velocity[i] * model_->opt.timestep;
    const double off = data->qpos[model_->jnt_qposadr[joints_[i]]] - command.position[i];
    lags[i] = std::abs(off - std::clamp(off, std::min(ahead, 0.0), std::max(ahead, 0.0)));
  }
  return lags;
}

}  // namespace rangegrasp::sim::internal
