#include "sim/grasp_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/linear_algebra.h"
#include "base/rng.h"
#include "sim/resting_poses.h"

namespace rangegrasp::sim::samples {
namespace {

constexpr double kApproach_m = 0.15;
constexpr double kLift_m = 0.2;
constexpr double kClearance_m = 0.004;
constexpr double kPeriod_s = 0.01;

// Quintic motion from rest to rest along a path of joint positions; the fastest joint stays within
// 0.35 rad/s and 1.2 rad/s^2.
base::JointTrajectory Timed(const std::vector<Eigen::VectorXd>& path) {
  std::vector<double> length(1, 0.0);
  for (std::size_t i = 1; i < path.size(); ++i) {
    length.push_back(length.back() + (path[i] - path[i - 1]).cwiseAbs().maxCoeff());
  }
  const double total = length.back();
  const double duration = std::max({1.875 * total / 0.35, std::sqrt(5.78 * total / 1.2), 0.1});
  base::JointTrajectory trajectory;
  trajectory.period_s = kPeriod_s;
  const int samples = static_cast<int>(std::ceil(duration / kPeriod_s));
  for (int k = 0; k <= samples; ++k) {
    const double u = static_cast<double>(k) / samples;
    const double s = total * u * u * u * (10 - 15 * u + 6 * u * u);
    std::size_t i = 1;
    while (i + 1 < path.size() && length[i] < s) ++i;
    const double span = length[i] - length[i - 1];
    const double w = span > 0 ? std::clamp((s - length[i - 1]) / span, 0.0, 1.0) : 1.0;
    trajectory.positions.emplace_back((1 - w) * path[i - 1] + w * path[i]);
  }
  return trajectory;
}

base::Pose GraspFrame(const HandMadeGrasp& grasp) {
  const Eigen::Vector3d x(std::cos(grasp.yaw_rad), std::sin(grasp.yaw_rad), 0.0);
  Eigen::Matrix3d R_WG;
  R_WG.col(0) = x;
  R_WG.col(2) = -Eigen::Vector3d::UnitZ();
  R_WG.col(1) = R_WG.col(2).cross(x);
  // A rotation about y_G that moves x_G (the thumb's side) towards z_G (down).
  R_WG = R_WG * Eigen::AngleAxisd(-grasp.pitch_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return base::MakePose(R_WG, grasp.point_W);
}

base::Pose Raised(base::Pose X, double dz) {
  X.translation().z() += dz;
  return X;
}

}  // namespace

TestArm::TestArm(const World& world)
    : model_(world.model()),
      data_(mj_makeData(model_)),
      hand_(mjcf::Find(model_, mjOBJ_BODY, "hand")),
      joints_(mjcf::TupleOf(model_, mjOBJ_JOINT, "arm_joints")) {
  mju_copy(data_->qpos, world.data()->qpos, static_cast<int>(model_->nq));
}

base::Pose TestArm::HandPose(const Eigen::VectorXd& q) {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    data_->qpos[model_->jnt_qposadr[joints_[i]]] = q[i];
  }
  mj_kinematics(model_, data_.get());
  mj_comPos(model_, data_.get());
  return mjcf::BodyPose(data_.get(), hand_);
}

base::Pose TestArm::ToolInHand() {
  mj_kinematics(model_, data_.get());
  return mjcf::BodyPose(data_.get(), hand_).inverse() *
         mjcf::SitePose(data_.get(), mjcf::Find(model_, mjOBJ_SITE, "tcp"));
}

std::optional<Eigen::VectorXd> TestArm::Solve(const base::Pose& X_WH, Eigen::VectorXd q) {
  const auto n = static_cast<Eigen::Index>(joints_.size());
  std::vector<mjtNum> jp(3 * static_cast<std::size_t>(model_->nv)), jr(jp.size());
  for (int iteration = 0; iteration < 300; ++iteration) {
    const base::Pose X = HandPose(q);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = X_WH.translation() - X.translation();
    const Eigen::AngleAxisd turn(X_WH.linear() * X.linear().transpose());
    error.tail<3>() = turn.angle() * turn.axis();
    if (error.head<3>().norm() < 1e-5 && error.tail<3>().norm() < 1e-4) return q;
    mj_jacBody(model_, data_.get(), jp.data(), jr.data(), hand_);
    Eigen::MatrixXd J(6, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int dof = model_->jnt_dofadr[joints_[i]];
      for (int k = 0; k < 3; ++k) {
        J(k, i) = jp[k * model_->nv + dof];
        J(k + 3, i) = jr[k * model_->nv + dof];
      }
    }
    const Eigen::MatrixXd A = J * J.transpose() + 1e-4 * Eigen::MatrixXd::Identity(6, 6);
    Eigen::VectorXd step = J.transpose() * base::SolveLdlt<Eigen::Dynamic, 1>(A, error);
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > 0.2) step *= 0.2 / largest;
    for (Eigen::Index i = 0; i < n; ++i) {
      const mjtNum* range = model_->jnt_range + 2 * joints_[i];
      q[i] = std::clamp(q[i] + step[i], range[0] + 0.02, range[1] - 0.02);
    }
  }
  return std::nullopt;
}

World StandingAlone(const std::filesystem::path& scene, const ObjectModel& object,
                    const PhysicsOptions& physics) {
  World world(scene, {object}, physics);
  const auto poses = StableRestingPoses(object, 0.0);
  const RestingFace face = *FaceAtRest(poses, Eigen::Matrix3d::Identity())->face;
  world.PlaceObject(0,
                    base::MakePose(face.R_WO.toRotationMatrix(), {0, 0, face.height_m + 0.0002}));
  EXPECT_TRUE(world.Settle());
  return world;
}

bool Delivered(const ExecutionLog& log) {
  return log.held_after_lift && log.held_after_carry && log.lift_height_m > 0.1 && log.at_rest &&
         log.on_support && !log.touched_by_hand && log.final_distance_m < 0.15;
}

GraspProgram MakeProgram(const World& world, const HandMadeGrasp& grasp) {
  TestArm arm(world);
  const base::Pose X_GH = arm.ToolInHand().inverse();
  const base::Pose X_WG = GraspFrame(grasp);
  base::Pose X_WDelivery = X_WG;
  X_WDelivery.translation().head<2>() = world.SitePose("delivery").translation().head<2>();
  // The hand turns with the arm's first joint, so that the wrist stays within its range.
  const Eigen::Vector2d from(X_WG.translation().x() + 0.5, X_WG.translation().y());
  const Eigen::Vector2d to(X_WDelivery.translation().x() + 0.5, X_WDelivery.translation().y());
  const double swing = std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x());
  X_WDelivery.linear() = Eigen::AngleAxisd(swing, Eigen::Vector3d::UnitZ()) * X_WG.linear();

  const auto line = [&](const base::Pose& X_start, double dz, const Eigen::VectorXd& seed) {
    std::vector<Eigen::VectorXd> path;
    Eigen::VectorXd q = seed;
    for (int k = 0; k <= 20; ++k) {
      const auto next = arm.Solve(Raised(X_start, dz * k / 20.0) * X_GH, q);
      if (!next) return std::vector<Eigen::VectorXd>();
      q = *next;
      path.push_back(q);
    }
    return path;
  };

  const Eigen::VectorXd home = world.ArmPositions();
  base::Rng rng(1);
  for (int attempt = 0; attempt < 60; ++attempt) {
    Eigen::VectorXd seed = home;
    seed[1] = 0.4;
    seed[3] = 1.5;
    seed[5] = 1.0;
    for (Eigen::Index i = 0; attempt > 0 && i < seed.size(); ++i) seed[i] += rng.Uniform(-1.2, 1.2);
    const auto above = arm.Solve(Raised(X_WG, kApproach_m) * X_GH, seed);
    if (!above) continue;
    const auto down = line(Raised(X_WG, kApproach_m), -kApproach_m, *above);
    if (down.empty()) continue;
    const auto up = line(X_WG, kLift_m, down.back());
    if (up.empty()) continue;
    Eigen::VectorXd swung = up.back();
    swung[0] += swing;
    const auto over = arm.Solve(Raised(X_WDelivery, kLift_m) * X_GH, swung);
    if (!over) continue;
    const auto lower = line(Raised(X_WDelivery, kLift_m), kClearance_m - kLift_m, *over);
    if (lower.empty()) continue;
    const auto retreat = line(Raised(X_WDelivery, kClearance_m), kApproach_m, lower.back());
    if (retreat.empty()) continue;
    GraspProgram program;
    program.opening_m = grasp.opening_m;
    program.reach = Timed({home, *above});
    program.approach = Timed(down);
    program.lift = Timed(up);
    program.carry = Timed({up.back(), *over});
    program.lower = Timed(lower);
    program.retreat = Timed(retreat);
    return program;
  }
  throw std::runtime_error("the arm does not reach the grasp");
}

}  // namespace rangegrasp::sim::samples
