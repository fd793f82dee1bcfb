#include "robot/planning/planning.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "base/linear_algebra.h"
#include "robot/ik.h"
#include "robot/planning/internal/motions.h"

namespace rangegrasp::planning {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using internal::Branch;
using internal::BranchBuilder;
using internal::JointPath;
using internal::MotionCheck;
using internal::Stage;
using internal::Task;

/// The projection to an upright hand takes at most this many steps, with damping [rad^2] far below
/// the Jacobian's squared entries of about 1. It ends when the hand tilts by less than this, well
/// within PlanOptions::carry_tilt_rad.
constexpr int kUprightSteps = 20;
constexpr double kUprightDamping = 0.01;
constexpr double kUpright_rad = 0.02;

/// If a rounded path touches something, its corners are rounded less, and at last not at all.
constexpr double kCornerShares[] = {1.0, 0.2, 0.0};

/// The most frequent key, the first of equals; empty if there is none.
std::string MostFrequent(const std::map<std::string, int>& counts) {
  using Count = std::map<std::string, int>::value_type;
  return counts.empty() ? "" : std::ranges::max_element(counts, {}, &Count::second)->first;
}

/// Turns the hand upright again (up_H along z_W) by a few steps of its two tilt components.
void ProjectUpright(const robot::Robot& robot, const Vector3d& up_H, VectorXd& q) {
  Eigen::MatrixXd J;
  for (int i = 0; i < kUprightSteps; ++i) {
    const base::Pose X_WH = robot.HandPoseAndJacobian(q, J);
    const Vector3d up_W = X_WH.linear() * up_H;
    const Eigen::Vector2d error = up_W.cross(Vector3d::UnitZ()).head<2>();
    if (up_W.z() > 0.0 && error.norm() < kUpright_rad) return;
    const auto J_tilt = J.middleRows<2>(3);
    Eigen::Matrix2d A = J_tilt * J_tilt.transpose();
    A.diagonal().array() += kUprightDamping;
    q += J_tilt.transpose() * base::SolveLdlt(A, error);
    q = q.cwiseMax(robot.lower).cwiseMin(robot.upper);
  }
}

}  // namespace

struct Planner::Impl {
  Impl(const robot::Robot& a_robot, PlanOptions some_options)
      : robot(a_robot),
        options(some_options),
        check(robot, options.collision_margin_m, options.cell_margin_m) {}

  /// Sorts by the time [s] that the slowest joint needs plus the cost of joints near their limits.
  void SortByCost(const VectorXd& from, std::vector<VectorXd>& solutions) const {
    std::ranges::stable_sort(solutions, {}, [&](const VectorXd& q) {
      const double travel_s = ((q - from).array().abs() / robot.velocity.array()).maxCoeff();
      const Eigen::ArrayXd room = (q - robot.lower).cwiseMin(robot.upper - q).array();
      return travel_s +
             options.limit_cost_s * (1.0 - room / options.limit_zone_rad).max(0.0).square().sum();
    });
  }

  /// Timed motion along a path; corners are tighter if the rounded path touches something.
  std::optional<base::JointTrajectory> Timed(const JointPath& path,
                                             const robot::TimingOptions& timing,
                                             const Stage& stage) {
    for (const double share : kCornerShares) {
      robot::TimingOptions tighter = timing;
      tighter.corner_rad *= share;
      base::JointTrajectory trajectory = TimeParameterise(robot, path, tighter);
      if (check.PathFree(Thinned(trajectory.positions), stage, options.resolution_rad)) {
        return trajectory;
      }
    }
    return {};
  }

  /// Samples about half a resolution apart, and the last one.
  JointPath Thinned(const JointPath& samples) const {
    JointPath out{samples.front()};
    for (const VectorXd& q : samples) {
      if ((q - out.back()).norm() > 0.5 * options.resolution_rad) out.push_back(q);
    }
    out.push_back(samples.back());
    return out;
  }

  std::optional<base::JointTrajectory> PlanMotion(const VectorXd& from, const VectorXd& to,
                                                  const Stage& stage,
                                                  const robot::TimingOptions& timing,
                                                  base::Rng& rng) {
    internal::JointQuery query{.start = from,
                               .goal = to,
                               .free = [&](const auto& q) { return check.Free(q, stage); },
                               .project = {},
                               .resolution_rad = options.resolution_rad,
                               .iterations = options.planning_iterations,
                               .seconds = options.planning_s};
    if (stage.min_upright > -1.0) {
      query.project = [&](VectorXd& q) { ProjectUpright(robot, stage.up_H, q); };
    }
    const auto path = internal::PlanJointPath(robot, query, rng);
    return path ? Timed(*path, timing, stage) : std::nullopt;
  }

  std::vector<Branch> Branches(const PickRequest& request, base::Rng& rng) {
    robot::IkOptions ik;
    const int drawn = options.ik_per_branch * options.ik_solutions;
    ik.max_solutions = drawn;
    ik.starts = 2 * drawn;  // about every second start gives a new solution
    std::vector<VectorXd> solutions = SolveIk(robot, request.X_WH, request.q_start, ik, rng);
    SortByCost(request.q_start, solutions);
    std::vector<Branch> branches;
    for (const VectorXd& q : solutions) branches.emplace_back().q_grasp = q;
    return branches;
  }

  /// The first branches whose approach is free; those that also carry on the arc come first.
  std::vector<Branch> Feasible(const BranchBuilder& builder, std::vector<Branch> branches) {
    std::vector<Branch> whole, rest;
    for (Branch& branch : branches) {
      std::string why;
      if (!builder.Approach(branch, why)) {
        ++blocked[why];
        continue;
      }
      const bool carries = builder.Lift(branch) && builder.CarryOnArc(branch);
      (carries ? whole : rest).push_back(std::move(branch));
      if (static_cast<int>(whole.size() + rest.size()) >= options.ik_solutions) break;
    }
    whole.insert(whole.end(), rest.begin(), rest.end());
    return whole;
  }

  /// Plans the carry in joint space to any delivery from which the object can be lowered.
  std::optional<base::JointTrajectory> FreeCarry(const BranchBuilder& builder, const Task& task,
                                                 Branch& branch, base::Rng& rng) {
    if (branch.lift.empty()) return {};
    Stage stage = builder.CarryStage(branch.lift.back());
    auto carry = FreeCarry(builder, task, stage, branch, rng);
    if (carry || !stage.contacts.cell_margin) return carry;
    stage.contacts.cell_margin = false;  // a narrow cell may leave no room for it
    return FreeCarry(builder, task, stage, branch, rng);
  }

  std::optional<base::JointTrajectory> FreeCarry(const BranchBuilder& builder, const Task& task,
                                                 const Stage& stage, Branch& branch,
                                                 base::Rng& rng) {
    const VectorXd q_lift = branch.lift.back();
    robot::IkOptions ik;
    ik.max_solutions = options.ik_solutions;
    int goals = 0;
    for (double yaw_rad : internal::DeliveryYaws(task, options.carry_yaws)) {
      const base::Pose X_WEnd = internal::CarryPose(task, yaw_rad, 1.0, task.lift_m);
      auto solutions = SolveIk(robot, X_WEnd, q_lift, ik, rng);
      SortByCost(q_lift, solutions);
      for (const VectorXd& q : solutions) {
        branch.carry = {q_lift, q};
        if (!check.Free(q, stage) || !builder.LowerAndRetreat(yaw_rad, branch)) continue;
        auto carry = PlanMotion(q_lift, q, stage, options.held_motion, rng);
        if (carry) return carry;
        if (++goals == options.carry_goals) return {};
      }
    }
    return {};
  }

  /// Completes the branch's motions once the reach is known.
  std::optional<PickPlan> Complete(const BranchBuilder& builder, const Task& task, Branch branch,
                                   base::JointTrajectory reach, base::Rng& rng) {
    PickPlan plan;
    std::optional<base::JointTrajectory> carry =
        branch.carry.empty() ? FreeCarry(builder, task, branch, rng)
                             : TimeParameterise(robot, branch.carry, options.held_motion);
    if (!carry) return {};
    plan.reach = std::move(reach);
    plan.carry = std::move(*carry);
    plan.approach = TimeParameterise(robot, branch.approach, options.free_motion);
    plan.lift = TimeParameterise(robot, branch.lift, options.held_motion);
    plan.lower = TimeParameterise(robot, branch.lower, options.held_motion);
    plan.retreat = TimeParameterise(robot, branch.retreat, options.free_motion);
    return plan;
  }

  /// The feasible branches. If none carries on the arc, those of a shorter approach and lift if one
  /// of them does, or if there are no others.
  std::vector<Branch> FeasibleOrShorter(const BranchBuilder& builder,
                                        const std::vector<Branch>& all, Task& task) {
    const auto carries = [](const std::vector<Branch>& branches) {
      return !branches.empty() && !branches.front().carry.empty();
    };
    std::vector<Branch> branches = Feasible(builder, all);
    if (carries(branches)) return branches;
    const Task whole = task;
    task.approach_m *= options.shortened;
    task.lift_m *= options.shortened;
    std::vector<Branch> shorter = Feasible(builder, all);
    if (carries(shorter) || branches.empty()) return shorter;
    task = whole;
    return branches;
  }

  /// Completes the motion of the first branch that is reached from q_start and carries.
  void CompleteFirst(const BranchBuilder& builder, const Task& task, const PickRequest& request,
                     std::vector<Branch> branches, base::Rng& rng, PlanResult& result) {
    result.failure = branches.empty() ? PlanFailure::kApproachBlocked : PlanFailure::kNoReach;
    if (branches.empty()) result.blocked_by = MostFrequent(blocked);
    for (Branch& branch : branches) {
      auto reach = PlanMotion(request.q_start, branch.approach.front(), builder.ReachStage(),
                              options.free_motion, rng);
      if (!reach) continue;
      result.failure = PlanFailure::kNoCarry;
      result.plan = Complete(builder, task, std::move(branch), std::move(*reach), rng);
      if (!result.plan) continue;
      result.failure = PlanFailure::kNone;
      return;
    }
    if (result.failure == PlanFailure::kNoReach) {
      result.blocked_by = check.WhyNot(request.q_start, builder.ReachStage());
    }
  }

  PlanResult Plan(const PickRequest& request, base::Rng& rng) {
    PlanResult result;
    blocked.clear();
    const std::vector<Branch> all = Branches(request, rng);
    result.failure = PlanFailure::kNoIk;
    if (!all.empty()) {
      Task task = internal::MakeTask(robot, scene, request, options, check.collider());
      const BranchBuilder builder(robot, options, check, task);
      CompleteFirst(builder, task, request, FeasibleOrShorter(builder, all, task), rng, result);
    }
    return result;
  }

  const robot::Robot& robot;
  PlanOptions options;
  PlanningScene scene;
  MotionCheck check;
  std::map<std::string, int> blocked;  // of this plan's approaches, by what was in the way
};

Planner::Planner(const robot::Robot& robot, PlanOptions options)
    : impl_(std::make_unique<Impl>(robot, options)) {}
Planner::~Planner() = default;

void Planner::SetScene(PlanningScene scene) {
  impl_->check.collider().SetScene(scene.table_z_m, scene.obstacles_W, scene.target_W);
  impl_->scene = std::move(scene);
}

PlanResult Planner::Plan(const PickRequest& request, base::Rng& rng) {
  return impl_->Plan(request, rng);
}

// A default stage: the hand open, everything an obstacle.
bool Planner::IsFree(const VectorXd& q) const { return impl_->check.Free(q, Stage()); }

std::optional<base::JointTrajectory> Planner::PlanMotion(const VectorXd& q_start,
                                                         const VectorXd& q_goal, base::Rng& rng) {
  return impl_->PlanMotion(q_start, q_goal, Stage(), impl_->options.free_motion, rng);
}

}  // namespace rangegrasp::planning
