#include "robot/planning/internal/branch.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "robot/straight_line.h"

namespace rangegrasp::planning::internal {
namespace {

using Target = collision::Contacts::Target;

/// Of the hand above the table when it lets go: as in a grasp (GraspOptions::table_clearance_m).
constexpr double kHandClearance_m = 0.004;
/// An arc is longer than its chord: 1.2 of it up to an arc of about 120 deg.
constexpr double kArcPerChord = 1.2;

Eigen::Vector3d Middle(const geometry::TriangleMesh& mesh, const Eigen::Vector3d& otherwise) {
  if (mesh.vertices.empty()) return otherwise;
  Eigen::Vector3d low = mesh.vertices.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return 0.5 * (low + high);
}

double Lowest(const geometry::TriangleMesh& mesh, double otherwise) {
  double lowest = mesh.vertices.empty() ? otherwise : mesh.vertices.front().z();
  for (const Eigen::Vector3d& v : mesh.vertices) lowest = std::min(lowest, v.z());
  return lowest;
}

double Wrapped(double angle) { return std::remainder(angle, 2.0 * base::kPi); }

double Azimuth(const Eigen::Vector3d& v) { return std::atan2(v.y(), v.x()); }

base::Pose TurnedAbout(const Eigen::Vector3d& center_W, double yaw_rad) {
  return Eigen::Translation3d(center_W) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::Translation3d(-center_W);
}

base::Pose Shifted(const base::Pose& X, const Eigen::Vector3d& by_W) {
  base::Pose out = X;
  out.translation() += by_W;
  return out;
}

}  // namespace

Task MakeTask(const robot::Robot& robot, const PlanningScene& scene, const PickRequest& request,
              const PlanOptions& options, const collision::RobotCollider& collider) {
  Task task;
  task.X_WH = request.X_WH;
  task.approach_m = options.approach_m;
  task.lift_m = options.lift_m;
  task.approach_W = request.approach_W.normalized();
  task.center_W = Middle(scene.target_W, request.X_WH.translation());
  task.open_state = robot.hand().IndexAtGap(request.opening_m);
  task.closed_state = robot.hand().IndexAtGap(request.closed_gap_m);
  task.may_brush = request.may_brush;
  task.base_W = robot.links().front().X_PB.translation();
  double below = Lowest(scene.target_W, scene.table_z_m) - scene.table_z_m;
  if (below < options.standing_m) below = 0.0;
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
  const Eigen::Vector3d from = task.center_W - task.base_W;
  const Eigen::Vector3d to = task.delivered_W - task.base_W;
  const double angle = Azimuth(from) + t * Wrapped(Azimuth(to) - Azimuth(from));
  const double radius = (1.0 - t) * from.head<2>().norm() + t * to.head<2>().norm();
  const Eigen::Vector3d center_W(task.base_W.x() + radius * std::cos(angle),
                                 task.base_W.y() + radius * std::sin(angle), task.center_W.z());
  const base::Pose turned = TurnedAbout(task.center_W, t * yaw_rad) * task.X_WH;
  return Shifted(turned, center_W - task.center_W + dz_m * Eigen::Vector3d::UnitZ());
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

Stage BranchBuilder::CarryStage() const {
  Stage stage = HeldStage();
  stage.contacts.may_touch_table = false;
  stage.up_H = task_.X_WH.linear().transpose() * Eigen::Vector3d::UnitZ();
  stage.min_upright = std::cos(options_.carry_tilt_rad);
  return stage;
}

bool BranchBuilder::Approach(Branch& branch, std::string& why) const {
  const base::Pose X_WStart = Shifted(task_.X_WH, -task_.approach_m * task_.approach_W);
  auto up = robot::StraightLine(robot_, branch.q_grasp, X_WStart, options_.step_m);
  if (!up) {
    why = "no straight way within the joints' limits";
    return false;
  }
  Stage stage = ReachStage();
  const auto free = [&](const Eigen::VectorXd& q) {
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
  const base::Pose X_WLifted = Shifted(task_.X_WH, task_.lift_m * Eigen::Vector3d::UnitZ());
  auto path = robot::StraightLine(robot_, branch.q_grasp, X_WLifted, options_.step_m);
  if (!path) return false;
  // What leans on the object, or what it stands on, touches it at first; once they have parted it
  // is in the way like all else. What still touches it at the end of the lift blocks the carry.
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
  const Eigen::Vector3d back_W =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * (-task_.approach_W);
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
  const Eigen::Vector3d way = X_WEnd.translation() - X_WLifted.translation();
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
  const Stage stage = CarryStage();
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
