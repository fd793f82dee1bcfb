// What the arm reaches, whether its drives carry it there, and how it holds and follows.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/units.h"
#include "robot/collision/robot_collider.h"
#include "robot/ik.h"
#include "robot/mjcf/hand_file.h"
#include "robot/robot.h"
#include "robot/timing.h"
#include "sim/arm_test.h"
#include "sim/check/internal/model.h"
#include "sim/world.h"

namespace rangegrasp::check::internal {
namespace {

// A grasp from above at this height over the table, and from so much higher at the start of its
// approach, with the hand turned in so many ways.
constexpr double kGrasp_m = 0.06;
constexpr double kApproach_m = 0.2;
constexpr int kYaws = 8;
constexpr double kAside = 0.8;             // of the workspace's radius: places beside its middle
constexpr double kLoad_kg = 1.0;           // that the drives carry beside the hand
constexpr double kMotionMargin_m = 0.003;  // as the planner's
constexpr double kHold_s = 2.0;
constexpr double kHold_m = 0.001;
// Half of the lag that counts as a thing in the way (5 mrad, sim/execute.cpp) is the arm's own.
constexpr double kLag_rad = 0.004;
// A cure is tried before it is told: so many rounds, in each of which what falls behind gets so
// much slower at least, but no slower than this.
constexpr int kRounds = 10;
constexpr double kSlower = 0.8;
constexpr double kSlowest_rad_s2 = 0.05;
constexpr double kSwing_rad = 0.3;  // of the motion that is tried, from home and back

struct Place {
  const char* name;
  Eigen::Vector3d p_W;
  bool needed;
};

std::vector<Place> Places(const robot::Robot& robot) {
  const Eigen::Vector3d middle = robot.X_WWorkspace.translation();
  const double r = kAside * robot.workspace_radius_m;
  return {{"the workspace's middle", middle, true},
          {"the delivery place", robot.X_WDelivery.translation(), true},
          {"the workspace's side at +x", middle + Eigen::Vector3d(r, 0, 0), false},
          {"the workspace's side at -x", middle + Eigen::Vector3d(-r, 0, 0), false},
          {"the workspace's side at +y", middle + Eigen::Vector3d(0, r, 0), false},
          {"the workspace's side at -y", middle + Eigen::Vector3d(0, -r, 0), false}};
}

/// The hand's pose with the tool's centre at p_W, its approach straight down.
base::Pose FromAbove(const robot::Robot& robot, const Eigen::Vector3d& p_W, double yaw_rad) {
  Eigen::Matrix3d R = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  R.col(1) *= -1.0;
  R.col(2) *= -1.0;
  return base::MakePose(R, p_W) * robot.hand().X_HG_tip.inverse();
}

struct Reached {
  std::optional<Eigen::VectorXd> q;
  std::map<std::string, int> why;  // not
};

Reached Reach(const robot::Robot& robot, collision::RobotCollider& collider,
              const Eigen::Vector3d& p_W, base::Rng& rng) {
  Reached reached;
  for (int i = 0; i < kYaws && !reached.q; ++i) {
    const double yaw_rad = 2.0 * base::kPi * i / kYaws;
    const Eigen::Vector3d grasp_W = p_W + Eigen::Vector3d(0, 0, kGrasp_m);
    const auto low = SolveIk(robot, FromAbove(robot, grasp_W, yaw_rad), robot.home, {}, rng);
    const Eigen::Vector3d start_W = grasp_W + Eigen::Vector3d(0, 0, kApproach_m);
    for (const Eigen::VectorXd& q : low) {
      if (const auto touch = collider.FirstTouch(robot.LinkPoses(q), {})) {
        ++reached.why[collider.TextOf(*touch) + " touch"];
        continue;
      }
      if (SolveIk(robot, FromAbove(robot, start_W, yaw_rad), q, {}, rng).empty()) {
        ++reached.why["0.2 m above it there is no position of the joints"];
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
  return std::max_element(reached.why.begin(), reached.why.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Joint positions above the places that are reached.
std::vector<Eigen::VectorXd> CheckReach(Model& model, const robot::Robot& robot) {
  collision::RobotCollider collider(robot, kMotionMargin_m);
  collider.SetScene(0.0, {}, {});
  base::Rng rng(1);
  std::vector<Eigen::VectorXd> positions;
  for (const Place& place : Places(robot)) {
    const Reached reached = Reach(robot, collider, place.p_W, rng);
    if (reached.q) {
      positions.push_back(*reached.q);
      continue;
    }
    const std::string what =
        fmt::format("does not bring the hand from above to {}: {}", place.name, Reason(reached));
    const std::string cure =
        "move the arm's base nearer or turn it, or move the site; 0.4 to 0.6 of its reach from its "
        "shoulder is good";
    place.needed ? model.Error(model.file().string(), "the arm", what, cure)
                 : model.Warn(model.file().string(), "the arm", what, cure);
  }
  return positions;
}

/// The torque [Nm] that each joint needs against the weight of arm, hand and load.
Eigen::VectorXd Weight(Model& model, const Eigen::VectorXd& q, double load_kg) {
  const mjModel& m = model.m();
  mjData& d = model.d();
  const auto n = static_cast<Eigen::Index>(model.arm_joints.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    d.qpos[m.jnt_qposadr[model.arm_joints[static_cast<std::size_t>(i)]]] = q[i];
  }
  mj_kinematics(&m, &d);
  mj_comPos(&m, &d);
  Eigen::VectorXd torque = Eigen::VectorXd::Zero(n);
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, m.nv);
  const auto add = [&](double mass_kg) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const int dof = m.jnt_dofadr[model.arm_joints[static_cast<std::size_t>(i)]];
      for (int k = 0; k < 3; ++k) torque[i] -= J(k, dof) * mass_kg * m.opt.gravity[k];
    }
  };
  for (int body = 1; body < m.nbody; ++body) {
    if (!model.IsRobot(body)) continue;
    mj_jacBodyCom(&m, &d, J.data(), nullptr, body);
    add(m.body_mass[body]);
  }
  const int tool = mjcf::ToolSite(&model.m(), "tcp_tip");
  if (tool >= 0) {
    mj_jacSite(&m, &d, J.data(), nullptr, tool);
    add(load_kg);
  }
  return torque.cwiseAbs();
}

/// What a drive can give [Nm]; infinite where the file says no limit.
double StrengthOf(const Model& model, std::size_t i) {
  const mjModel& m = model.m();
  double strength = mjMAXVAL;
  const int joint = model.arm_joints[i];
  const int actuator = model.arm_actuators[i];
  if (m.jnt_actfrclimited[joint]) {
    strength = std::min(m.jnt_actfrcrange[2 * joint + 1], -m.jnt_actfrcrange[2 * joint]);
  }
  if (m.actuator_forcelimited[actuator]) {
    const mjtNum* range = m.actuator_forcerange + 2 * actuator;
    strength = std::min({strength, range[1], -range[0]});
  }
  return strength;
}

void CheckStrength(Model& model, const std::vector<Eigen::VectorXd>& positions) {
  Eigen::VectorXd most = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.arm_joints.size()));
  for (const Eigen::VectorXd& q : positions) most = most.cwiseMax(Weight(model, q, kLoad_kg));
  const Eigen::Map<const Eigen::VectorXd> home(model.home.data(), most.size());
  most = most.cwiseMax(Weight(model, home, 0.0));
  model.SetHome();
  for (std::size_t i = 0; i < model.arm_joints.size(); ++i) {
    const double needed = most[static_cast<Eigen::Index>(i)];
    const double strength = StrengthOf(model, i);
    if (needed < strength) continue;
    const int actuator = model.arm_actuators[i];
    model.Error(
        model.Where(mjOBJ_ACTUATOR, actuator), model.Element(mjOBJ_ACTUATOR, actuator),
        fmt::format("gives {:.3g} Nm, and joint \"{}\" needs {:.3g} Nm to carry arm, hand and "
                    "{:g} kg where it works",
                    strength, model.Name(mjOBJ_JOINT, model.arm_joints[i]), needed, kLoad_kg),
        fmt::format("forcerange=\"-{0:.0f} {0:.0f}\" (and actuatorfrcrange of the joint), or a "
                    "stronger arm",
                    std::ceil(1.5 * needed)));
  }
}

std::string StiffnessCure(const Model& model, std::size_t i, double by) {
  const int actuator = model.arm_actuators[i];
  const double kp = model.m().actuator_gainprm[actuator * mjNGAIN];
  return fmt::format(
      "kp=\"{:.2g}\" dampratio=\"1\" in place of {:g} (of a <general>: gainprm, and "
      "biasprm with the damping as its third number)",
      kp * by, kp);
}

bool CheckHold(Model& model, sim::World& world) {
  const sim::HoldReport report = sim::HoldStill(world, kHold_s);
  if (report.drift_m <= kHold_m) return true;
  Eigen::Index worst = 0;
  report.sag_rad.maxCoeff(&worst);
  const auto i = static_cast<std::size_t>(worst);
  model.Error(
      model.Where(mjOBJ_ACTUATOR, model.arm_actuators[i]),
      model.Element(mjOBJ_ACTUATOR, model.arm_actuators[i]),
      fmt::format("does not hold the arm at home: within {:g} s the hand moves by {:.3g} mm, "
                  "joint \"{}\" by {:.3g} rad",
                  kHold_s, 1e3 * report.drift_m, model.Name(mjOBJ_JOINT, model.arm_joints[i]),
                  report.sag_rad[worst]),
      StiffnessCure(model, i, std::max(2.0, 2.0 * report.drift_m / kHold_m)));
  return false;
}

/// From home a little to the side of more room, and back; less far, or to the other side, where
/// something is in the way. Empty where something always is.
base::JointTrajectory Swing(const robot::Robot& robot) {
  collision::RobotCollider collider(robot, kMotionMargin_m);
  collider.SetScene(0.0, {}, {});
  for (const double share : {1.0, -1.0, 0.5, -0.5, 0.25, -0.25}) {
    Eigen::VectorXd aside = robot.home;
    for (Eigen::Index i = 0; i < aside.size(); ++i) {
      const bool up = robot.upper[i] - robot.home[i] > robot.home[i] - robot.lower[i];
      aside[i] = std::clamp(robot.home[i] + share * (up ? kSwing_rad : -kSwing_rad), robot.lower[i],
                            robot.upper[i]);
    }
    base::JointTrajectory swing = TimeParameterise(robot, {robot.home, aside, robot.home}, {});
    const bool free =
        std::none_of(swing.positions.begin(), swing.positions.end(), [&](const Eigen::VectorXd& q) {
          return collider.FirstTouch(robot.LinkPoses(q), {}).has_value();
        });
    if (free) return swing;
  }
  return {};
}

/// How far each joint falls behind in a swing at the robot's limits, from home; empty where there
/// is no room for a swing.
Eigen::VectorXd LagOf(sim::World& world, const robot::Robot& robot) {
  const base::JointTrajectory swing = Swing(robot);
  if (swing.positions.empty()) return {};
  const auto before = world.Save();
  const Eigen::VectorXd lag = sim::LagBehind(world, swing);
  world.Restore(*before);
  return lag;
}

/// Accelerations with which no joint falls behind; of one that falls behind however slow, the last
/// that was tried.
std::string SlowEnough(sim::World& world, robot::Robot robot, Eigen::VectorXd lag) {
  for (int i = 0; i < kRounds && lag.size() > 0 && lag.maxCoeff() > kLag_rad; ++i) {
    for (Eigen::Index k = 0; k < lag.size(); ++k) {
      if (lag[k] <= kLag_rad) continue;
      const double slower = robot.acceleration[k] * std::min(kSlower, kLag_rad / lag[k]);
      robot.acceleration[k] = std::floor(100.0 * slower) / 100.0;
    }
    robot.acceleration = robot.acceleration.cwiseMax(kSlowest_rad_s2);
    lag = LagOf(world, robot);
  }
  std::string values;
  for (const double a : robot.acceleration) {
    values += fmt::format("{}{:g}", values.empty() ? "" : " ", a);
  }
  return values;
}

void CheckFollowing(Model& model, sim::World& world, const robot::Robot& robot) {
  const Eigen::VectorXd lag = LagOf(world, robot);
  std::vector<int> slow;
  std::string stiffer;
  for (Eigen::Index i = 0; i < lag.size(); ++i) {
    if (lag[i] <= kLag_rad) continue;
    const int actuator = model.arm_actuators[static_cast<std::size_t>(i)];
    slow.push_back(actuator);
    const double kp = model.m().actuator_gainprm[actuator * mjNGAIN];
    stiffer += fmt::format("{}{:.0f} in place of {:g}", stiffer.empty() ? "" : ", ",
                           kp * lag[i] / (kSlower * kLag_rad), kp);
  }
  if (slow.empty()) return;
  model.Error(
      model.Where(mjOBJ_ACTUATOR, slow.front()), "actuators " + model.NamesOf(mjOBJ_ACTUATOR, slow),
      fmt::format("fall up to {:.1f} mrad behind in a motion at the joints' own limits; from "
                  "5 mrad on that is taken for a thing in the way",
                  1e3 * lag.maxCoeff()),
      fmt::format("<numeric name=\"joint_acceleration\" data=\"{}\"/>, or stiffer drives: kp "
                  "{}, with their damping",
                  SlowEnough(world, robot, lag), stiffer));
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
