#include "robot/planning/internal/motions.h"

#include <ompl/base/ScopedState.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "base/units.h"
#include "robot/ik.h"

namespace rangegrasp::planning::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace ob = ompl::base;
namespace og = ompl::geometric;
using JointSpace = ob::RealVectorStateSpace;

constexpr double kTreeStep_rad = 0.6;  ///< longer ones are less free, shorter ones more numerous
constexpr int kShortcuts = 80;         ///< tried per path; each checks one edge
constexpr double kWorthwhile = 0.999;  ///< a shortcut's largest relative length, against rounding

Eigen::Map<VectorXd> Values(ob::State* state, Eigen::Index dof) {
  return {state->as<JointSpace::StateType>()->values, dof};
}
Eigen::Map<const VectorXd> Values(const ob::State* state, Eigen::Index dof) {
  return {state->as<JointSpace::StateType>()->values, dof};
}

/// Draws from our own stream: OMPL's generators are seeded once for the whole process. RRTConnect
/// only asks for uniform samples.
class Sampler : public ob::RealVectorStateSampler {
 public:
  Sampler(const ob::StateSpace* space, const robot::Robot& robot, const JointQuery& query,
          base::Rng& rng)
      : ob::RealVectorStateSampler(space), robot_(robot), query_(query), draws_(rng) {}

  void sampleUniform(ob::State* state) override {
    VectorXd q(robot_.dof());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      q[i] = draws_.Uniform(robot_.lower[i], robot_.upper[i]);
    }
    if (query_.project) query_.project(q);
    Values(state, q.size()) = q.cwiseMax(robot_.lower).cwiseMin(robot_.upper);
  }

 private:
  const robot::Robot& robot_;
  const JointQuery& query_;
  base::Rng& draws_;
};

std::shared_ptr<JointSpace> MakeSpace(const robot::Robot& robot, const JointQuery& query,
                                      base::Rng& rng) {
  const auto dof = static_cast<unsigned int>(robot.dof());
  auto space = std::make_shared<JointSpace>(dof);
  ob::RealVectorBounds bounds(dof);
  for (unsigned int i = 0; i < dof; ++i) {
    bounds.setLow(i, robot.lower[i]);
    bounds.setHigh(i, robot.upper[i]);
  }
  space->setBounds(bounds);
  space->setLongestValidSegmentFraction(query.resolution_rad / space->getMaximumExtent());
  space->setStateSamplerAllocator(
      [&](const ob::StateSpace* s) { return std::make_shared<Sampler>(s, robot, query, rng); });
  return space;
}

std::optional<JointPath> SolveRrtConnect(const robot::Robot& robot, const JointQuery& query,
                                         base::Rng& rng) {
  ompl::msg::noOutputHandler();
  const Eigen::Index dof = robot.dof();
  const auto space = MakeSpace(robot, query, rng);
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return query.free(Values(state, dof)); });
  information->setup();
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<JointSpace> start(space);
  ob::ScopedState<JointSpace> goal(space);
  Values(start.get(), dof) = query.start;
  Values(goal.get(), dof) = query.goal;
  problem->setStartAndGoalStates(start, goal);

  og::RRTConnect planner(information);
  planner.setRange(kTreeStep_rad);
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setProblemDefinition(problem);
  planner.setup();
  int iterations = 0;
  const base::Stopwatch watch;
  const ob::PlannerTerminationCondition done(
      [&] { return ++iterations > query.iterations || watch.Seconds() > query.seconds; });
  if (planner.solve(done) != ob::PlannerStatus::EXACT_SOLUTION) return {};
  JointPath path;
  for (const ob::State* state : problem->getSolutionPath()->as<og::PathGeometric>()->getStates()) {
    path.emplace_back(Values(state, dof));
  }
  return path;
}

/// Joins two random points of the path by a straight line where that is free and shorter.
void Shortcut(const JointQuery& query, base::Rng& rng, JointPath& path) {
  for (int k = 0; k < kShortcuts && path.size() > 2; ++k) {
    const double last = static_cast<double>(path.size() - 1);
    double a = rng.Uniform(0.0, last);
    double b = rng.Uniform(0.0, last);
    if (a > b) std::swap(a, b);
    const int i = static_cast<int>(a);
    const int j = static_cast<int>(b);
    if (i == j) continue;
    const VectorXd from = path[i] + (a - i) * (path[i + 1] - path[i]);
    const VectorXd to = path[j] + (b - j) * (path[j + 1] - path[j]);
    double length = (path[i + 1] - from).norm() + (to - path[j]).norm();
    for (int n = i + 1; n < j; ++n) length += (path[n + 1] - path[n]).norm();
    const bool shorter = !((to - from).norm() > kWorthwhile * length);
    if (!shorter || !EdgeFree(query.free, from, to, query.resolution_rad)) continue;
    path.erase(path.begin() + i + 1, path.begin() + j + 1);
    path.insert(path.begin() + i + 1, {from, to});
  }
}

using Target = collision::Contacts::Target;

/// Of the hand above the table at the release: as in a grasp (GraspOptions::table_clearance_m).
constexpr double kHandClearance_m = 0.004;
/// An arc's length per chord: 1.2 up to an arc of about 120 deg.
constexpr double kArcPerChord = 1.2;

double Wrapped(double angle) { return std::remainder(angle, 2.0 * base::kPi); }

double Azimuth(const Vector3d& v) { return std::atan2(v.y(), v.x()); }

base::Pose TurnedAbout(const Vector3d& center_W, double yaw_rad) {
  return Eigen::Translation3d(center_W) * Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) *
         Eigen::Translation3d(-center_W);
}

base::Pose Shifted(base::Pose X, const Vector3d& by_W) {
  X.translation() += by_W;
  return X;
}

}  // namespace

std::optional<JointPath> PlanJointPath(const robot::Robot& robot, const JointQuery& query,
                                       base::Rng& rng) {
  if (!query.free(query.start) || !query.free(query.goal)) return {};
  if (EdgeFree(query.free, query.start, query.goal, query.resolution_rad))
    return JointPath{query.start, query.goal};
  std::optional<JointPath> path = SolveRrtConnect(robot, query, rng);
  if (path) Shortcut(query, rng, *path);
  return path;
}

bool EdgeFree(const std::function<bool(const VectorXd&)>& free, const VectorXd& from,
              const VectorXd& to, double resolution_rad) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / resolution_rad)));
  for (int i = 1; i <= steps; ++i) {
    if (!free(from + (to - from) * (static_cast<double>(i) / steps))) return false;
  }
  return true;
}

bool MotionCheck::Free(const VectorXd& q, const Stage& stage) {
  if ((q.array() < robot_.lower.array()).any() || (q.array() > robot_.upper.array()).any()) {
    return false;
  }
  const std::vector<base::Pose> links_W = robot_.LinkPoses(q);
  const base::Pose X_WH = links_W.back() * robot_.X_FH;
  if ((X_WH.linear() * stage.up_H).z() < stage.min_upright) return false;
  return !collider_.Hits(links_W, stage.contacts);
}

std::string MotionCheck::WhyNot(const VectorXd& q, const Stage& stage) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (q[i] < robot_.lower[i] || q[i] > robot_.upper[i]) {
      return "joint " + std::to_string(i + 1) + " is beyond its range";
    }
  }
  const auto touch = collider_.FirstTouch(robot_.LinkPoses(q), stage.contacts);
  if (touch) return collider_.TextOf(*touch);
  return Free(q, stage) ? "" : "the hand leans too far";
}

bool MotionCheck::PathFree(const JointPath& path, const Stage& stage, double resolution_rad) {
  if (path.empty() || !Free(path.front(), stage)) return false;
  const auto free = [&](const VectorXd& q) { return Free(q, stage); };
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!EdgeFree(free, path[i - 1], path[i], resolution_rad)) return false;
  }
  return true;
}

Task MakeTask(const robot::Robot& robot, const PlanningScene& scene, const PickRequest& request,
              const PlanOptions& options, const collision::RobotCollider& collider) {
  Task task;
  task.X_WH = request.X_WH;
  task.approach_m = options.approach_m;
  task.lift_m = options.lift_m;
  task.approach_W = request.approach_W.normalized();
  const bool seen = !scene.target_W.vertices.empty();
  const Eigen::AlignedBox3d box_W = geometry::BoundsOf(scene.target_W.vertices);
  task.center_W = request.X_WH.translation();
  if (seen) task.center_W = box_W.center();
  task.open_state = robot.hand().IndexAtGap(request.opening_m);
  task.closed_state = robot.hand().IndexAtGap(request.closed_gap_m);
  task.may_brush = request.may_brush;
  task.base_W = robot.links().front().X_PB.translation();
  double below = seen ? box_W.min().z() - scene.table_z_m : 0.0;
  if (below < options.standing_m) {
    task.below_m = std::max(0.0, below);
    below = 0.0;
  }
  const double hand = std::min(collider.LowestOfHand(request.X_WH, task.open_state),
                               collider.LowestOfHand(request.X_WH, task.closed_state));
  const double drop = std::max(0.0, std::min(below, hand - scene.table_z_m - kHandClearance_m));
  task.delivered_W = robot.X_WDelivery.translation();
  task.delivered_W.z() = task.center_W.z() - drop + options.lower_clearance_m;
  return task;
}

std::vector<double> DeliveryYaws(const Task& task, int count) {
  const double round =
      Azimuth(task.delivered_W - task.base_W) - Azimuth(task.center_W - task.base_W);
  std::vector<double> yaws;
  for (int k = 0; k < count; ++k) {
    // 0, +1, -1, +2, -2, ...
    const int offset = k % 2 == 1 ? (k + 1) / 2 : -k / 2;
    yaws.push_back(Wrapped(round + offset * 2.0 * base::kPi / count));
  }
  return yaws;
}

base::Pose CarryPose(const Task& task, double yaw_rad, double t, double dz_m) {
  const Vector3d from = task.center_W - task.base_W;
  const Vector3d to = task.delivered_W - task.base_W;
  const double angle = Azimuth(from) + t * Wrapped(Azimuth(to) - Azimuth(from));
  const double radius = (1.0 - t) * from.head<2>().norm() + t * to.head<2>().norm();
  const Vector3d center_W(task.base_W.x() + radius * std::cos(angle),
                          task.base_W.y() + radius * std::sin(angle), task.center_W.z());
  const base::Pose turned = TurnedAbout(task.center_W, t * yaw_rad) * task.X_WH;
  return Shifted(turned, center_W - task.center_W + dz_m * Vector3d::UnitZ());
}

Stage BranchBuilder::ReachStage() const {
  Stage stage;
  stage.contacts.hand_state = task_.open_state;
  return stage;
}

Stage BranchBuilder::HeldStage() const {
  Stage stage;
  stage.contacts.hand_state = task_.closed_state;
  stage.contacts.hand_margin = false;
  stage.contacts.target = Target::kHeld;
  stage.contacts.X_HT = task_.X_WH.inverse();
  stage.contacts.may_touch_table = true;
  return stage;
}

Stage BranchBuilder::CarryStage(const VectorXd& q_lift) const {
  Stage stage = HeldStage();
  stage.contacts.may_touch_table = false;
  stage.up_H = task_.X_WH.linear().transpose() * Vector3d::UnitZ();
  stage.min_upright = std::cos(options_.carry_tilt_rad);
  stage.contacts.held_below_m = task_.below_m;
  stage.contacts.cell_margin = true;
  stage.contacts.cell_margin = check_.Free(q_lift, stage);
  return stage;
}

bool BranchBuilder::Approach(Branch& branch, std::string& why) const {
  const base::Pose X_WStart = Shifted(task_.X_WH, -task_.approach_m * task_.approach_W);
  auto up = robot::StraightLine(robot_, branch.q_grasp, X_WStart, options_.step_m);
  if (!up) {
    why = "no straight path within the joints' limits";
    return false;
  }
  Stage stage = ReachStage();
  const auto free = [&](const VectorXd& q) {
    if (check_.Free(q, stage)) return true;
    why = check_.WhyNot(q, stage);
    return false;
  };
  if (!free(up->back())) return false;
  stage.contacts.hand_margin = false;
  for (std::size_t i = 0; i < up->size(); ++i) {
    const double to_go =
        task_.approach_m * static_cast<double>(i) / static_cast<double>(up->size() - 1);
    stage.contacts.target = to_go <= options_.contact_m ? Target::kHandMayTouch : Target::kObstacle;
    if (!free((*up)[i])) return false;
  }
  branch.approach.assign(up->rbegin(), up->rend());
  return true;
}

bool BranchBuilder::Lift(Branch& branch) const {
  const base::Pose X_WLifted = Shifted(task_.X_WH, task_.lift_m * Vector3d::UnitZ());
  auto path = robot::StraightLine(robot_, branch.q_grasp, X_WLifted, options_.step_m);
  if (!path) return false;
  // What leans on the object, or what it stands on, is an obstacle once they have separated. If
  // something still touches it at the end of the lift, it blocks the carry.
  Stage stage = HeldStage();
  if (task_.may_brush) stage.contacts.target = Target::kGone;
  std::vector<char>& ignored = stage.contacts.held_ignores;
  if (!task_.may_brush) {
    ignored = check_.collider().TouchedByTarget(task_.X_WH, stage.contacts.X_HT);
  }
  for (std::size_t i = 1; i < path->size(); ++i) {
    if (!check_.PathFree({(*path)[i - 1], (*path)[i]}, stage, options_.resolution_rad)) {
      return false;
    }
    if (task_.may_brush) continue;
    const auto touched =
        check_.collider().TouchedByTarget(robot_.HandPose((*path)[i]), stage.contacts.X_HT);
    for (std::size_t k = 0; k < ignored.size(); ++k) ignored[k] = ignored[k] && touched[k];
  }
  branch.lift = std::move(*path);
  return true;
}

bool BranchBuilder::LowerAndRetreat(double yaw_rad, Branch& branch) const {
  const base::Pose X_WRelease =
      CarryPose(task_, yaw_rad, 1.0, task_.delivered_W.z() - task_.center_W.z());
  auto lower = robot::StraightLine(robot_, branch.carry.back(), X_WRelease, options_.step_m);
  if (!lower || !check_.PathFree(*lower, HeldStage(), options_.resolution_rad)) return false;
  const Vector3d back_W = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) * (-task_.approach_W);
  auto retreat = robot::StraightLine(
      robot_, lower->back(), Shifted(X_WRelease, options_.retreat_m * back_W), options_.step_m);
  Stage stage = ReachStage();
  stage.contacts.hand_margin = false;
  stage.contacts.target = Target::kGone;
  if (!retreat || !check_.PathFree(*retreat, stage, options_.resolution_rad)) return false;
  branch.lower = std::move(*lower);
  branch.retreat = std::move(*retreat);
  return true;
}

std::vector<base::Pose> BranchBuilder::ArcPoses(double yaw_rad, const base::Pose& X_WLifted) const {
  const base::Pose X_WEnd = CarryPose(task_, yaw_rad, 1.0, task_.lift_m);
  const Vector3d way = X_WEnd.translation() - X_WLifted.translation();
  const double length =
      std::max(kArcPerChord * way.norm(), robot::kRotationRadius_m * std::abs(yaw_rad));
  const int steps = std::max(1, static_cast<int>(std::ceil(length / options_.step_m)));
  std::vector<base::Pose> poses;
  for (int i = 1; i <= steps; ++i) {
    poses.push_back(CarryPose(task_, yaw_rad, static_cast<double>(i) / steps, task_.lift_m));
  }
  return poses;
}

bool BranchBuilder::CarryOnArc(Branch& branch) const {
  const Stage stage = CarryStage(branch.lift.back());
  for (double yaw_rad : DeliveryYaws(task_, options_.carry_yaws)) {
    auto path = robot::FollowPoses(robot_, branch.lift.back(),
                                   ArcPoses(yaw_rad, robot_.HandPose(branch.lift.back())));
    if (!path) continue;
    path->insert(path->begin(), branch.lift.back());
    if (!check_.PathFree(*path, stage, options_.resolution_rad)) continue;
    branch.carry = std::move(*path);
    if (LowerAndRetreat(yaw_rad, branch)) return true;
  }
  branch.carry.clear();
  return false;
}

}  // namespace rangegrasp::planning::internal
