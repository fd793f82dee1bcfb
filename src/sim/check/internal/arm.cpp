#include "sim/check/internal/arm.h"

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
#include "robot/robot.h"
#include "robot/timing.h"
#include "sim/internal/servo.h"
#include "sim/world.h"

namespace rangegrasp::check::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// With less armature, the engine sees almost no mass behind a light wrist, and held objects slip:
// an iiwa 14 without armature delivers 7 of 12, with 0.02 kg m^2 or more 12 of 12.
constexpr double kMinArmature = 0.01;
constexpr int kMinJoints = 6;            // fewer do not reach a general pose
constexpr int kMaxJoints = 7;            // with more, redundancy is left to chance
constexpr double kCompensated = 0.999;   // gravcomp of a body whose weight is carried
constexpr double kSameGain = 1e-6;       // of stiffness in gain and bias, relative; rounding
constexpr double kSameRange_rad = 1e-3;  // of a command and its joint; rounding of a file's numbers
constexpr double kSameTurn_rad = 5e-3;   // the same without a range: a turn is often 6.28

bool CheckChain(Model& model) {
  const mjModel& m = model.m();
  bool right = true;
  const auto wrong = [&](int joint, const std::string& what, const std::string& cure) {
    model.Error(mjOBJ_JOINT, joint, what, cure);
    right = false;
  };
  for (std::size_t i = 0; i < model.arm_joints.size(); ++i) {
    const int joint = model.arm_joints[i];
    const int body = m.jnt_bodyid[joint];
    if (m.jnt_type[joint] != mjJNT_HINGE) {
      wrong(joint, "is not a hinge; joints of \"arm_joints\" must be hinges",
            "model the arm with hinges");
    } else if (m.body_jntnum[body] > 1) {
      wrong(joint,
            fmt::format("body \"{}\" has {} joints; one is allowed", model.BodyName(body),
                        m.body_jntnum[body]),
            "give each joint its own body");
    } else if (model.hand >= 0 && !model.InSubtree(model.hand, body)) {
      wrong(joint, "does not move body \"hand\"",
            "attach the hand to the arm's last link, or remove the joint from \"arm_joints\"");
    } else if (i > 0 && !model.InSubtree(body, m.jnt_bodyid[model.arm_joints[i - 1]])) {
      wrong(joint,
            fmt::format(
                "is listed after \"{}\" in \"arm_joints\", but does not follow it in the chain",
                model.Name(mjOBJ_JOINT, model.arm_joints[i - 1])),
            "list the joints from base to tip, and the actuators in the same order");
    }
  }
  if (!right || model.hand < 0) return right;
  for (int body = m.body_parentid[model.hand]; body > 0; body = m.body_parentid[body]) {
    if (m.body_jntnum[body] == 0) continue;
    const int joint = m.body_jntadr[body];
    if (std::ranges::find(model.arm_joints, joint) != model.arm_joints.end()) continue;
    wrong(joint, "is between the world and the hand, but not in \"arm_joints\"",
          "list it in \"arm_joints\" and its drive in \"arm_actuators\", or remove the joint");
  }
  return right;
}

void CheckCount(Model& model) {
  const int n = static_cast<int>(model.arm_joints.size());
  if (n >= kMinJoints && n <= kMaxJoints) return;
  model.Report(
      n < kMinJoints, model.ArmFile(), "the arm",
      fmt::format("has {}; it needs 6 or 7 to move the hand to any pose",
                  base::Counted(n, "joint")),
      n < kMinJoints ? "list all joints in \"arm_joints\"" : "remove joints that it does not need");
}

void CheckHome(Model& model) {
  const mjModel& m = model.m();
  std::vector<std::string> bad;
  std::vector<double> values;
  for (std::size_t i = 0; i < model.home.size(); ++i) {
    const int joint = model.arm_joints[i];
    const mjtNum* range = m.jnt_range + 2 * joint;
    double value = model.home[i];
    if (m.jnt_limited[joint] && !(value >= range[0] && value <= range[1])) {
      bad.push_back(fmt::format("{} is {:.4g}, its range {:.4g} to {:.4g}",
                                model.Name(mjOBJ_JOINT, joint), value, range[0], range[1]));
      value = std::clamp(value, 0.9 * range[0] + 0.1 * range[1], 0.1 * range[0] + 0.9 * range[1]);
    }
    values.push_back(value);
  }
  if (bad.empty()) return;
  model.Error(mjOBJ_NUMERIC, "home",
              "is outside the joints' ranges [rad]: " + base::Join(bad, "; "),
              model.SetNumeric("home", fmt::format("{:.4g}", fmt::join(values, " ")), ""));
}

// A servo that keeps the file's force range and its own name; without one it gets that of
// "arm_actuators" in Model::SetTuple.
std::string ServoBlock(const Model& model, int joint, int actuator) {
  const mjModel& m = model.m();
  const std::string name(mjcf::Suffix(model.Name(mjOBJ_JOINT, joint)));
  const std::string own = actuator < 0 ? "" : model.Name(mjOBJ_ACTUATOR, actuator);
  std::string block =
      fmt::format("<position name=\"{}\" joint=\"{}\" kp=\"5000\" dampratio=\"1\"{}",
                  own.empty() ? "servo_" + name : mjcf::Suffix(own), name,
                  m.jnt_limited[joint] ? " inheritrange=\"1\"" : "");
  if (actuator >= 0 && m.actuator_forcelimited[actuator]) {
    const mjtNum* force = m.actuator_forcerange + 2 * actuator;
    block += fmt::format(" forcerange=\"{:g} {:g}\"", force[0], force[1]);
  }
  return block + "/>";
}

void CheckDrive(Model& model, int joint, int actuator) {
  const mjModel& m = model.m();
  const mjtNum* gain = m.actuator_gainprm + actuator * mjNGAIN;
  const mjtNum* bias = m.actuator_biasprm + actuator * mjNBIAS;
  const std::string name = model.Name(mjOBJ_JOINT, joint);
  const auto wrong = [&](const std::string& what, const Cure& cure) {
    model.Error(mjOBJ_ACTUATOR, actuator, what, cure);
  };
  if (m.actuator_trntype[actuator] != mjTRN_JOINT || m.actuator_trnid[2 * actuator] != joint) {
    return wrong(fmt::format("does not drive joint \"{}\"", name),
                 model.SetTuple("arm_actuators", mjOBJ_ACTUATOR, model.DrivesOfArm(), ""));
  }
  const Cure servo = model.Replace(mjOBJ_ACTUATOR, actuator, ServoBlock(model, joint, actuator));
  if (m.actuator_biastype[actuator] != mjBIAS_AFFINE || !(gain[0] > 0.0) ||
      std::abs(bias[1] + gain[0]) > kSameGain * gain[0]) {
    return wrong("is not a position servo", servo);
  }
  if (const double gear = m.actuator_gear[6 * actuator]; gear != 1.0) {
    return wrong(fmt::format("has a gear of {:g}, so that its command is not an angle", gear),
                 servo);
  }
  if (bias[2] == 0.0 && m.dof_damping[m.jnt_dofadr[joint]] == 0.0) {
    wrong("oscillates without end: neither it nor its joint is damped", servo);
  }
  const mjtNum* command = m.actuator_ctrlrange + 2 * actuator;
  if (!m.actuator_ctrllimited[actuator]) return;
  const auto [low, high] = model.RangeOf(joint, 2.0 * mjPI);
  const double same_rad = m.jnt_limited[joint] ? kSameRange_rad : kSameTurn_rad;
  if (command[0] <= low + same_rad && command[1] >= high - same_rad) return;
  wrong(fmt::format("accepts commands from {:.4g} to {:.4g} only, but joint \"{}\" turns from "
                    "{:.4g} to {:.4g}: motions are limited there",
                    command[0], command[1], name, low, high),
        model.Set(mjOBJ_ACTUATOR, actuator,
                  {{"ctrlrange", fmt::format("{:.6g} {:.6g}", low, high)}}) +
            ", or the same range for the joint");
}

void CheckArmature(Model& model) {
  const mjModel& m = model.m();
  std::vector<int> light;
  Cure cure;
  for (const int joint : model.arm_joints) {
    if (m.dof_armature[m.jnt_dofadr[joint]] >= kMinArmature) continue;
    light.push_back(joint);
    cure += model.Set(mjOBJ_JOINT, joint, {{"armature", "0.1"}});
  }
  if (light.empty()) return;
  model.Error(
      mjOBJ_JOINT, light,
      "have no or too little armature (the inertia of motor and gear): grasped objects slip and "
      "sink into the fingers",
      cure + " (kg m^2)");
}

void CheckGravity(Model& model) {
  const mjModel& m = model.m();
  // An arm that asks for compensation gets it once the hand is attached.
  const auto asked = model.Numeric("gravity_compensation");
  if (model.hand < 0 && asked.size() == 1 && asked[0] != 0.0) return;
  std::vector<int> heavy;
  for (const int body : model.RobotBodies()) {
    if (m.body_mass[body] > 0.0 && m.body_gravcomp[body] < kCompensated) heavy.push_back(body);
  }
  if (heavy.empty()) return;
  model.Error(mjOBJ_BODY, heavy, "are not compensated for gravity, so that the arm sags",
              model.SetNumeric("gravity_compensation", "1", model.ArmFile()) +
                  ": the drives then carry arm and hand (or gravcomp=\"1\" on each body)");
}

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

/// Joint positions for a grasp at p_W from above; without any, `why` is the most frequent reason.
std::optional<VectorXd> Reach(const robot::Robot& robot, collision::RobotCollider& collider,
                              const Vector3d& p_W, base::Rng& rng, std::string& why) {
  std::map<std::string, int> reasons;
  for (int i = 0; i < kYaws; ++i) {
    const double yaw_rad = 2.0 * base::kPi * i / kYaws;
    const Vector3d grasp_W = p_W + Vector3d(0, 0, kGrasp_m);
    const auto low = SolveIk(robot, FromAbove(robot, grasp_W, yaw_rad), robot.home, {}, rng);
    const Vector3d start_W = grasp_W + Vector3d(0, 0, kApproach_m);
    for (const VectorXd& q : low) {
      if (const auto touch = collider.FirstTouch(robot.LinkPoses(q), {})) {
        ++reasons[collider.TextOf(*touch) + " touch"];
      } else if (SolveIk(robot, FromAbove(robot, start_W, yaw_rad), q, {}, rng).empty()) {
        ++reasons["no joint positions reach 0.2 m above it"];
      } else {
        return q;
      }
    }
  }
  const auto times = [](const auto& reason) { return reason.second; };
  why =
      reasons.empty() ? "it is out of reach" : std::ranges::max_element(reasons, {}, times)->first;
  return std::nullopt;
}

/// Joint positions above the places that can be reached.
std::vector<VectorXd> CheckReach(Model& model, const robot::Robot& robot) {
  collision::RobotCollider collider(robot, kMotionMargin_m);
  collider.SetScene(0.0, {}, {});
  base::Rng rng(1);
  std::vector<VectorXd> positions;
  for (const Place& place : Places(robot)) {
    std::string why;
    if (const auto q = Reach(robot, collider, place.p_W, rng, why)) {
      positions.push_back(*q);
      continue;
    }
    model.Report(
        place.needed, model.file().string(), "the arm",
        fmt::format("does not move the hand from above to {}: {}", place.name, why),
        "move the arm's base nearer or turn it, or move the site; a distance of 0.4 to 0.6 of the "
        "reach from the shoulder is good");
  }
  return positions;
}

/// The torque [Nm] that each joint needs against the weight of arm, hand and load.
VectorXd Weight(Model& model, const VectorXd& q, double load_kg) {
  const mjModel& m = model.m();
  mjData& d = model.d();
  model.SetArm(q.data());
  mj_comPos(&m, &d);
  VectorXd torque = VectorXd::Zero(q.size());
  const auto add = [&](double mass_kg, int body, const mjtNum* center_W) {
    const auto J =
        sim::internal::JacobianOf(&m, &d, model.arm_joints, body, sim::internal::Vec3(center_W));
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      for (int k = 0; k < 3; ++k) torque[i] -= J(k, i) * mass_kg * m.opt.gravity[k];
    }
  };
  for (const int body : model.RobotBodies()) add(m.body_mass[body], body, d.xipos + 3 * body);
  const int tool = model.Find(mjOBJ_SITE, "tcp");
  if (tool >= 0) add(load_kg, m.site_bodyid[tool], d.site_xpos + 3 * tool);
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
    servo.Command(world.data(), command);
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

/// Largest lag of each joint [rad] (as a trial counts it) in a swing at the robot's limits; empty
/// if there is no room.
VectorXd LagOf(sim::World& world, const robot::Robot& robot) {
  const base::JointTrajectory swing = Swing(robot);
  if (swing.positions.empty()) return {};
  const auto before = world.Save();
  const sim::internal::ArmServo servo(world.model());
  VectorXd lag = VectorXd::Zero(robot.home.size());
  const double start_s = world.time_s();
  const double period_s = world.physics().timestep_s;
  while (world.time_s() - start_s < swing.Duration()) {
    const auto command = sim::internal::CommandAt(swing, world.time_s() - start_s + period_s);
    servo.Command(world.data(), command);
    world.Step();
    lag = lag.cwiseMax(servo.Lags(world.data(), command));
  }
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
      mjOBJ_ACTUATOR, slow,
      fmt::format("lag up to {:.1f} mrad behind in a motion at the joints' own limits; a lag of "
                  "more than 5 mrad counts as contact with an obstacle",
                  1e3 * lag.maxCoeff()),
      model.SetNumeric("joint_acceleration", SlowEnough(world, robot, lag), model.ArmFile()) +
          fmt::format(", or stiffer drives: kp {}, with their damping", base::Join(stiffer)));
}

}  // namespace

void CheckArm(Model& model) {
  if (!model.HasArm()) return;
  if (model.arm_joints.empty()) {
    return model.Error(model.ArmFile(), "the arm", "has no hinges", "name them in \"arm_joints\"");
  }
  CheckCount(model);
  if (!CheckChain(model)) return;
  CheckHome(model);
  for (std::size_t i = 0; i < model.arm_actuators.size(); ++i) {
    CheckDrive(model, model.arm_joints[i], model.arm_actuators[i]);
  }
  if (model.arm_actuators.empty()) {
    Cure cure;
    for (const int joint : model.arm_joints) {
      if (model.DriveOf(joint) >= 0) continue;
      cure += Cure::Insert(model.ArmFile(), "/*/actuator", ServoBlock(model, joint, -1));
    }
    model.Error(model.ArmFile(), "the arm",
                fmt::format("does not have one drive for each of its {} joints in "
                            "\"arm_actuators\"",
                            model.arm_joints.size()),
                cure + "\nand list them in the tuple \"arm_actuators\"");
  }
  CheckArmature(model);
  CheckGravity(model);
}

void CheckMotion(Model& model) {
  if (model.kind() != Kind::kScene || model.HasErrors()) return;
  const robot::Robot robot = robot::Robot::Load(model.file());
  CheckStrength(model, CheckReach(model, robot));
  if (model.HasErrors()) return;
  sim::World world(model.file(), {}, {});
  if (CheckHold(model, world)) CheckFollowing(model, world, robot);
}

}  // namespace rangegrasp::check::internal
