#include "planning/planning.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"
#include "planning/internal/branch.h"
#include "planning/internal/collision.h"
#include "planning/internal/joint_planner.h"

namespace rangegrasp::planning {
namespace {

using internal::Branch;
using internal::BranchBuilder;
using internal::CollisionModel;
using internal::JointPath;
using internal::Stage;
using internal::Task;

constexpr int kIkPerBranch = 8;     ///< solutions drawn for each branch that may be tried
constexpr double kShortened = 0.6;  ///< of approach and lift where the whole length is blocked
constexpr int kCarryGoals = 3;      ///< of the fallback that plans the carry in joint space

/// The time [s] that the slowest joint needs, and 1 s for each joint right at a limit, falling to 0
/// at 0.35 rad (20 deg) from it.
double Cost(const robot::Robot& robot, const Eigen::VectorXd& from, const Eigen::VectorXd& q) {
  const double travel_s = ((q - from).array().abs() / robot.velocity.array()).maxCoeff();
  const Eigen::ArrayXd room = (q - robot.lower).cwiseMin(robot.upper - q).array();
  return travel_s + (1.0 - room / 0.35).max(0.0).square().sum();
}

void SortByCost(const robot::Robot& robot, const Eigen::VectorXd& from,
                std::vector<Eigen::VectorXd>& solutions) {
  std::stable_sort(solutions.begin(), solutions.end(), [&](const auto& a, const auto& b) {
    return Cost(robot, from, a) < Cost(robot, from, b);
  });
}

/// Turns the hand upright again (up_H along z_W) by a few steps of its two tilt components.
void ProjectUpright(const robot::Robot& robot, const Eigen::Vector3d& up_H, Eigen::VectorXd& q) {
  Eigen::MatrixXd J;
  for (int i = 0; i < 20; ++i) {
    const core::Pose X_WH = robot.HandPoseAndJacobian(q, J);
    const Eigen::Vector3d up_W = X_WH.linear() * up_H;
    const Eigen::Vector2d error = up_W.cross(Eigen::Vector3d::UnitZ()).head<2>();
    if (up_W.z() > 0.0 && error.norm() < 0.02) return;
    const auto J_tilt = J.middleRows<2>(3);
    Eigen::Matrix2d A = J_tilt * J_tilt.transpose();
    A.diagonal().array() += 0.01;
    q += J_tilt.transpose() * A.ldlt().solve(error);
    q = q.cwiseMax(robot.lower).cwiseMin(robot.upper);
  }
}

}  // namespace

const char* Name(PlanFailure failure) {
  switch (failure) {
    case PlanFailure::kNone:
      return "none";
    case PlanFailure::kNoIk:
      return "no_ik";
    case PlanFailure::kApproachBlocked:
      return "approach_blocked";
    case PlanFailure::kNoReach:
      return "no_reach";
    case PlanFailure::kNoCarry:
      return "no_carry";
  }
  return "unknown";
}

struct Planner::Impl {
  Impl(const robot::Robot& a_robot, PlanOptions some_options)
      : robot(a_robot), options(some_options), model(robot, options.collision_margin_m) {}

  /// Timed motions of the branch; tighter corners where the rounded path touches something.
  std::optional<core::JointTrajectory> Timed(const JointPath& path,
                                             const robot::TimingOptions& timing,
                                             const Stage* stage) {
    for (double shrink : {1.0, 0.2, 0.0}) {
      robot::TimingOptions tighter = timing;
      tighter.corner_rad *= shrink;
      core::JointTrajectory trajectory = TimeParameterise(robot, path, tighter);
      if (stage == nullptr ||
          model.PathFree(Thinned(trajectory.positions), *stage, options.resolution_rad)) {
        return trajectory;
      }
    }
    return {};
  }

  /// Samples about half a resolution apart, and the last.
  JointPath Thinned(const JointPath& samples) const {
    JointPath out{samples.front()};
    for (const Eigen::VectorXd& q : samples) {
      if ((q - out.back()).norm() > 0.5 * options.resolution_rad) out.push_back(q);
    }
    out.push_back(samples.back());
    return out;
  }

  std::optional<core::JointTrajectory> PlanMotion(const Eigen::VectorXd& from,
                                                  const Eigen::VectorXd& to, const Stage& stage,
                                                  const robot::TimingOptions& timing,
                                                  core::Rng& rng) {
    internal::JointQuery query;
    query.start = from;
    query.goal = to;
    query.free = [&](const Eigen::VectorXd& q) { return model.Free(q, stage); };
    if (stage.least_upright > -1.0) {
      query.project = [&](Eigen::VectorXd& q) { ProjectUpright(robot, stage.up_H, q); };
    }
    query.resolution_rad = options.resolution_rad;
    query.iterations = options.planning_iterations;
    query.seconds = options.planning_s;
    const auto path = internal::PlanJointPath(robot, query, rng);
    return path ? Timed(*path, timing, &stage) : std::nullopt;
  }

  std::vector<Branch> Branches(const PickRequest& request, core::Rng& rng) {
    const auto most = static_cast<std::size_t>(kIkPerBranch * options.ik_solutions);
    robot::IkOptions ik;
    ik.starts = static_cast<int>(2 * most);
    std::vector<Eigen::VectorXd> solutions =
        SolveIk(robot, request.X_WH, request.q_start, ik, rng, most);
    SortByCost(robot, request.q_start, solutions);
    std::vector<Branch> branches;
    for (const Eigen::VectorXd& q : solutions) branches.emplace_back().q_grasp = q;
    return branches;
  }

  /// The first branches whose approach is free; those that also carry on the arc come first.
  std::vector<Branch> Feasible(const BranchBuilder& builder, std::vector<Branch> branches) {
    std::vector<Branch> whole, rest;
    for (Branch& branch : branches) {
      if (!builder.Approach(branch)) continue;
      const bool carries = builder.Lift(branch) && builder.CarryOnArc(branch);
      (carries ? whole : rest).push_back(std::move(branch));
      if (static_cast<int>(whole.size() + rest.size()) >= options.ik_solutions) break;
    }
    whole.insert(whole.end(), rest.begin(), rest.end());
    return whole;
  }

  /// Plans the carry in joint space to any delivery that can be lowered.
  std::optional<core::JointTrajectory> FreeCarry(const BranchBuilder& builder, const Task& task,
                                                 Branch& branch, core::Rng& rng) {
    if (branch.lift.empty()) return {};
    const Stage stage = builder.CarryStage(branch);
    const Eigen::VectorXd& q_lift = branch.lift.back();
    int goals = 0;
    for (double yaw_rad : internal::DeliveryYaws(task, options.carry_yaws)) {
      const core::Pose X_WEnd = internal::CarryPose(task, yaw_rad, 1.0, task.lift_m);
      auto solutions =
          SolveIk(robot, X_WEnd, q_lift, {}, rng, static_cast<std::size_t>(options.ik_solutions));
      SortByCost(robot, q_lift, solutions);
      for (const Eigen::VectorXd& q : solutions) {
        branch.carry = {q_lift, q};
        if (!model.Free(q, stage) || !builder.LowerAndRetreat(yaw_rad, branch)) continue;
        auto carry = PlanMotion(q_lift, q, stage, options.held_motion, rng);
        if (carry) return carry;
        if (++goals == kCarryGoals) return {};
      }
    }
    return {};
  }

  /// The branch's motions once the reach is known; sets failure where they cannot be had.
  std::optional<PickPlan> Complete(const BranchBuilder& builder, const Task& task, Branch branch,
                                   core::JointTrajectory reach, core::Rng& rng) {
    PickPlan plan;
    std::optional<core::JointTrajectory> carry =
        branch.carry.empty() ? FreeCarry(builder, task, branch, rng)
                             : Timed(branch.carry, options.held_motion, nullptr);
    if (!carry) return {};
    plan.reach = std::move(reach);
    plan.carry = std::move(*carry);
    plan.approach = TimeParameterise(robot, branch.approach, options.free_motion);
    plan.lift = TimeParameterise(robot, branch.lift, options.held_motion);
    plan.lower = TimeParameterise(robot, branch.lower, options.held_motion);
    plan.retreat = TimeParameterise(robot, branch.retreat, options.free_motion);
    return plan;
  }

  PlanResult Plan(const PlanningScene& scene, const PickRequest& request, core::Rng& rng) {
    core::Stopwatch watch;
    PlanResult result;
    std::vector<Branch> branches = Branches(request, rng);
    result.ik_s = watch.Restart();
    result.failure = PlanFailure::kNoIk;
    if (!branches.empty()) {
      model.SetScene(scene);
      Task task = internal::MakeTask(robot, scene, request, options, model);
      const BranchBuilder builder(robot, options, model, task);
      const std::vector<Branch> all = std::move(branches);
      branches = Feasible(builder, all);
      if (branches.empty() || branches.front().carry.empty()) {
        // High above the table the arm may lack the room: come from, and lift to, less far.
        task.approach_m *= kShortened;
        task.lift_m *= kShortened;
        std::vector<Branch> shorter = Feasible(builder, all);
        const bool better = !shorter.empty() && !shorter.front().carry.empty();
        if (better || branches.empty()) {
          branches = std::move(shorter);
        } else {
          task.approach_m /= kShortened;
          task.lift_m /= kShortened;
        }
      }
      result.failure = branches.empty() ? PlanFailure::kApproachBlocked : PlanFailure::kNoReach;
      for (Branch& branch : branches) {
        auto reach = PlanMotion(request.q_start, branch.approach.front(), builder.ReachStage(),
                                options.free_motion, rng);
        if (!reach) continue;
        result.failure = PlanFailure::kNoCarry;
        result.plan = Complete(builder, task, std::move(branch), std::move(*reach), rng);
        if (result.plan) break;
      }
      if (result.plan) result.failure = PlanFailure::kNone;
    }
    result.path_s = watch.Seconds();
    return result;
  }

  const robot::Robot& robot;
  PlanOptions options;
  CollisionModel model;
};

Planner::Planner(const robot::Robot& robot, PlanOptions options)
    : impl_(std::make_unique<Impl>(robot, options)) {}
Planner::~Planner() = default;

PlanResult Planner::Plan(const PlanningScene& scene, const PickRequest& request, core::Rng& rng) {
  return impl_->Plan(scene, request, rng);
}

}  // namespace rangegrasp::planning
