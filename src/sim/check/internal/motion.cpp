#include "sim/check/internal/motion.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/frames.h"
#include "base/units.h"
#include "base/words.h"
#include "robot/collision/collider.h"
#include "robot/ik.h"
#include "robot/mjcf/hand.h"
#include "robot/robot.h"
#include "robot/timing.h"
#include "sim/internal/engine.h"
#include "sim/internal/servo.h"
#include "sim/world.h"

namespace rangegrasp::check::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Tested grasps from above: height, start of the approach above it, and number of yaws.
constexpr double kGrasp_m = 0.06;
constexpr double kApproach_m = 0.2;
constexpr int kYaws = 8;
constexpr double kAside = 0.8;             // of the workspace's radius: places off its middle
constexpr double kLoad_kg = 1.0;           // that the drives carry in addition to the hand
constexpr double kMotionMargin_m = 0.003;  // as the planner's
constexpr double kHold_s = 2.0;
constexpr double kHold_m = 0.001;
// A free motion may lag by half of what counts as an obstacle (8 mrad, sim/execute.cpp).
constexpr double kLag_rad = 0.004;
// Fixes are tested first: in each round, lagging joints get slower by this factor, down to this.
constexpr int kRounds = 10;
constexpr double kSlower = 0.8;
constexpr double kSlowest_rad_s2 = 0.05;
constexpr double kSwing_rad = 0.3;  // of the test motion, from home and back

struct Place {
  const char* name;
  Vector3d p_W;
  bool needed;
};

std::vector<Place> Places(const robot::Robot& robot) {
  const Vector3d middle = robot.X_WWorkspace.translation();
  const Vector3d x = kAside * robot.workspace_radius_m * Vector3d::UnitX();
  const Vector3d y = kAside * robot.workspace_radius_m * Vector3d::UnitY();
  return {{"the workspace's middle", middle, true},
          {"the delivery place", robot.X_WDelivery.translation(), true},
          {"the workspace's side at +x", middle + x, false},
          {"the workspace's side at -x", middle - x, false},
          {"the workspace's side at +y", middle + y, false},
          {"the workspace's side at -y", middle - y, false}};
}

/// The hand's pose with the tool's centre at p_W and its approach straight down.
base::Pose FromAbove(const robot::Robot& robot, const Vector3d& p_W, double yaw_rad) {
  Eigen::Matrix3d R = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  R.col(1) *= -1.0;
  R.col(2) *= -1.0;
  return base::MakePose(R, p_W) * robot.hand().X_HG_tip.inverse();
}

struct Reached {
  std::optional<VectorXd> q;
  std::map<std::string, int> why;  // how often each reason prevented it
};

Reached Reach(const robot::Robot& robot, collision::RobotCollider& collider, const Vector3d& p_W,
              base::Rng& rng) {
  Reached reached;
  for (int i = 0; i < kYaws && !reached.q; ++i) {
    const double yaw_rad = 2.0 * base::kPi * i / kYaws;
    const Vector3d grasp_W = p_W + Vector3d(0, 0, kGrasp_m);
    const auto low = SolveIk(robot, FromAbove(robot, grasp_W, yaw_rad), robot.home, {}, rng);
    const Vector3d start_W = grasp_W + Vector3d(0, 0, kApproach_m);
    for (const VectorXd& q : low) {
      if (const auto touch = collider.FirstTouch(robot.LinkPoses(q), {})) {
        ++reached.why[collider.TextOf(*touch) + " touch"];
        continue;
      }
      if (SolveIk(robot, FromAbove(robot, start_W, yaw_rad), q, {}, rng).empty()) {
        ++reached.why["no joint positions reach 0.2 m above it"];
        continue;
      }
      reached.q = q;
      break;
    }
  }
  return reached;
}

std::string Reason(const Reached& reached) {
  if (reached.why.empty()) return "it is out of reach";
  using Count = std::map<std::string, int>::value_type;
  return std::ranges::max_element(reached.why, {}, &Count::second)->first;
}

/// Joint positions above the places that can be reached.
std::vector<VectorXd> CheckReach(Model& model, const robot::Robot& robot) {
  collision::RobotCollider collider(robot, kMotionMargin_m);
  collider.SetScene(0.0, {}, {});
  base::Rng rng(1);
  std::vector<VectorXd> positions;
  for (const Place& place : Places(robot)) {
    const Reached reached = Reach(robot, collider, place.p_W, rng);
    if (reached.q) {
      positions.push_back(*reached.q);
      continue;
    }
    model.Report(
        place.needed, model.file().string(), "the arm",
        fmt::format("does not move the hand from above to {}: {}", place.name, Reason(reached)),
        "move the arm's base nearer or turn it, or move the site; a distance of 0.4 to 0.6 of the "
        "reach from the shoulder is good");
  }
  return positions;
}

/// The torque [Nm] that each joint needs against the weight of arm, hand and load.
VectorXd Weight(Model& model, const VectorXd& q, double load_kg) {
  const mjModel& m = model.m();
  mjData& d = model.d();
  const std::size_t n = model.arm_joints.size();
  for (std::size_t i = 0; i < n; ++i) d.qpos[m.jnt_qposadr[model.arm_joints[i]]] = q[i];
  mj_kinematics(&m, &d);
  mj_comPos(&m, &d);
  VectorXd torque = VectorXd::Zero(n);
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, m.nv);
  const auto add = [&](double mass_kg) {
    for (std::size_t i = 0; i < n; ++i) {
      const int dof = m.jnt_dofadr[model.arm_joints[i]];
      for (int k = 0; k < 3; ++k) torque[i] -= J(k, dof) * mass_kg * m.opt.gravity[k];
    }
  };
  for (int body = 1; body < m.nbody; ++body) {
    if (!model.IsRobot(body)) continue;
    mj_jacBodyCom(&m, &d, J.data(), nullptr, body);
    add(m.body_mass[body]);
  }
  const int tool = model.Find(mjOBJ_SITE, "tcp");
  if (tool >= 0) {
    mj_jacSite(&m, &d, J.data(), nullptr, tool);
    add(load_kg);
  }
  return torque.cwiseAbs();
}

void CheckStrength(Model& model, const std::vector<VectorXd>& positions) {
  VectorXd most = VectorXd::Zero(model.arm_joints.size());
  for (const VectorXd& q : positions) most = most.cwiseMax(Weight(model, q, kLoad_kg));
  const Eigen::Map<const VectorXd> home(model.home.data(), most.size());
  most = most.cwiseMax(Weight(model, home, 0.0));
  model.SetHome();
  for (std::size_t i = 0; i < model.arm_joints.size(); ++i) {
    const double needed = most[i];
    const double strength =
        sim::internal::DriveLimit(&model.m(), model.arm_joints[i], model.arm_actuators[i]);
    if (needed < strength) continue;
    model.Error(
        mjOBJ_ACTUATOR, model.arm_actuators[i],
        fmt::format("gives {:.3g} Nm, but joint \"{}\" needs {:.3g} Nm to carry arm, hand and {:g} "
                    "kg in its working poses",
                    strength, model.Name(mjOBJ_JOINT, model.arm_joints[i]), needed, kLoad_kg),
        fmt::format("forcerange=\"-{0:.0f} {0:.0f}\" (and actuatorfrcrange of the joint), or a "
                    "stronger arm",
                    std::ceil(1.5 * needed)));
  }
}

/// Moves the arm along a trajectory from its present position, as a trial does.
/// @return the largest lag of each joint [rad] (as a trial counts it)
VectorXd LagBehind(sim::World& world, const base::JointTrajectory& trajectory) {
  const sim::internal::ArmServo servo(world.model());
  VectorXd lag = VectorXd::Zero(world.ArmPositions().size());
  const double start_s = world.time_s();
  const double period_s = world.physics().timestep_s;
  while (world.time_s() - start_s < trajectory.Duration()) {
    const auto command = sim::internal::CommandAt(trajectory, world.time_s() - start_s + period_s);
    servo.Command(world.model(), world.data(), command);
    world.Step();
    lag = lag.cwiseMax(servo.Lags(world.model(), world.data(), command));
  }
  return lag;
}

/// Commands the arm to stay where it is for kHold_s, with no force of the hand.
/// @throws base::InputError if the scene has no arm or no hand
bool CheckHold(Model& model, sim::World& world) {
  const int hand = sim::internal::Find(world.model(), mjOBJ_BODY, "hand");
  const auto place_W = [&] {
    return Vector3d(sim::internal::BodyPose(world.data(), hand).translation());
  };
  const sim::internal::ArmServo servo(world.model());
  const auto command = sim::internal::StayAt(world.ArmPositions());
  world.Refresh();
  const Vector3d start_W = place_W();
  double drift_m = 0.0;                 // largest displacement of the hand's root body
  VectorXd sag_rad = command.velocity;  // largest deviation of each joint from its command
  for (const double end_s = world.time_s() + kHold_s; world.time_s() < end_s;) {
    servo.Command(world.model(), world.data(), command);
    world.Step();
    const double way_m = (place_W() - start_W).norm();
    if (!(way_m <= drift_m)) drift_m = way_m;  // NaN counts as large
    sag_rad = sag_rad.cwiseMax((world.ArmPositions() - command.position).cwiseAbs());
  }
  if (drift_m <= kHold_m) return true;
  Eigen::Index worst = 0;
  sag_rad.maxCoeff(&worst);
  const int actuator = model.arm_actuators[worst];
  model.Error(
      mjOBJ_ACTUATOR, actuator,
      fmt::format("does not hold the arm at home: within {:g} s the hand moves by {:.3g} mm, "
                  "joint \"{}\" by {:.3g} rad",
                  kHold_s, 1e3 * drift_m, model.Name(mjOBJ_JOINT, model.arm_joints[worst]),
                  sag_rad[worst]),
      model.Stiffer(actuator, std::max(2.0, 2.0 * drift_m / kHold_m)));
  return false;
}

/// A motion from home towards each joint's larger free range, and back; shorter, or to the other
/// side, if that is not free. Empty if none is free.
base::JointTrajectory Swing(const robot::Robot& robot) {
  collision::RobotCollider collider(robot, kMotionMargin_m);
  collider.SetScene(0.0, {}, {});
  for (const double share : {1.0, -1.0, 0.5, -0.5, 0.25, -0.25}) {
    VectorXd aside = robot.home;
    for (Eigen::Index i = 0; i < aside.size(); ++i) {
      const bool up = robot.upper[i] - robot.home[i] > robot.home[i] - robot.lower[i];
      aside[i] += share * (up ? kSwing_rad : -kSwing_rad);
    }
    aside = aside.cwiseMax(robot.lower).cwiseMin(robot.upper);
    base::JointTrajectory swing = TimeParameterise(robot, {robot.home, aside, robot.home}, {});
    const auto hits = [&](const VectorXd& q) { return collider.Hits(robot.LinkPoses(q), {}); };
    if (std::ranges::none_of(swing.positions, hits)) return swing;
  }
  return {};
}

/// Largest lag of each joint in a swing at the robot's limits; empty if there is no room.
VectorXd LagOf(sim::World& world, const robot::Robot& robot) {
  const base::JointTrajectory swing = Swing(robot);
  if (swing.positions.empty()) return {};
  const auto before = world.Save();
  const VectorXd lag = LagBehind(world, swing);
  world.Restore(*before);
  return lag;
}

/// Accelerations at which no joint lags too much, or the last ones tried.
std::string SlowEnough(sim::World& world, robot::Robot robot, VectorXd lag) {
  for (int i = 0; i < kRounds && lag.size() > 0 && lag.maxCoeff() > kLag_rad; ++i) {
    for (Eigen::Index k = 0; k < lag.size(); ++k) {
      if (lag[k] <= kLag_rad) continue;
      const double slower = robot.acceleration[k] * std::min(kSlower, kLag_rad / lag[k]);
      robot.acceleration[k] = std::floor(100.0 * slower) / 100.0;
    }
    robot.acceleration = robot.acceleration.cwiseMax(kSlowest_rad_s2);
    lag = LagOf(world, robot);
  }
  return fmt::format("{:g}", fmt::join(robot.acceleration.begin(), robot.acceleration.end(), " "));
}

void CheckFollowing(Model& model, sim::World& world, const robot::Robot& robot) {
  const VectorXd lag = LagOf(world, robot);
  std::vector<int> slow;
  std::vector<std::string> stiffer;
  for (Eigen::Index i = 0; i < lag.size(); ++i) {
    if (lag[i] <= kLag_rad) continue;
    const int actuator = model.arm_actuators[i];
    slow.push_back(actuator);
    const double kp = model.m().actuator_gainprm[actuator * mjNGAIN];
    stiffer.push_back(
        fmt::format("{:.0f} instead of {:g}", kp * lag[i] / (kSlower * kLag_rad), kp));
  }
  if (slow.empty()) return;
  model.Error(
      model.Where(mjOBJ_ACTUATOR, slow.front()), "actuators " + model.NamesOf(mjOBJ_ACTUATOR, slow),
      fmt::format("lag up to {:.1f} mrad behind in a motion at the joints' own limits; a lag of "
                  "more than 5 mrad counts as contact with an obstacle",
                  1e3 * lag.maxCoeff()),
      model.SetNumeric("joint_acceleration", SlowEnough(world, robot, lag), model.ArmFile()) +
          fmt::format(", or stiffer drives: kp {}, with their damping", base::Join(stiffer)));
}

}  // namespace

void CheckMotion(Model& model) {
  if (model.kind() != Kind::kScene || model.HasErrors()) return;
  const robot::Robot robot = robot::Robot::Load(model.file());
  CheckStrength(model, CheckReach(model, robot));
  if (model.HasErrors()) return;
  sim::World world(model.file(), {}, {});
  if (CheckHold(model, world)) CheckFollowing(model, world, robot);
}

}  // namespace rangegrasp::check::internal
