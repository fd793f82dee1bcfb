// The arm's chain, ranges, drives, armature and gravity compensation.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {
namespace {

// With less of it on a joint, what the hand holds sinks into the glove and slips, since the engine
// sees next to no mass behind a light wrist: an iiwa 14 without armature delivers 7 of 12, with
// 0.02 kg m^2 and more 12 of 12.
constexpr double kMinArmature = 0.01;
constexpr int kMinJoints = 6;  // fewer reach no pose in general
constexpr int kMaxJoints = 7;  // of more, redundancy is left to chance
// Of a body whose weight is carried.
constexpr double kCompensated = 0.999;
constexpr double kSameGain = 1e-6;  // of stiffness in gain and bias, relative; rounding
// A command's range may fall short of the joint's by this; rounding of a file's numbers.
constexpr double kSameRange_rad = 1e-3;

std::string DefaultJoint(const Model& model, const std::string& attribute) {
  const std::string place = model.lines().JointDefaultOf(model.ArmFile());
  if (!place.empty())
    return fmt::format("{} in the <joint> of the default at {}", attribute, place);
  return fmt::format("<default> <joint {}/> </default> at the top of {}", attribute,
                     model.ArmFile());
}

bool CheckChain(Model& model) {
  const mjModel& m = model.m();
  bool right = true;
  const auto wrong = [&](int joint, const std::string& what, const std::string& cure) {
    model.Error(model.Where(mjOBJ_JOINT, joint), model.Element(mjOBJ_JOINT, joint), what, cure);
    right = false;
  };
  for (std::size_t i = 0; i < model.arm_joints.size(); ++i) {
    const int joint = model.arm_joints[i];
    const int body = m.jnt_bodyid[joint];
    if (m.jnt_type[joint] != mjJNT_HINGE) {
      wrong(joint, "is no hinge, and joints of \"arm_joints\" are", "model the arm with hinges");
    } else if (m.body_jntnum[body] > 1) {
      wrong(joint,
            fmt::format("body \"{}\" has {} joints, it may have one", model.BodyName(body),
                        m.body_jntnum[body]),
            "give each joint a body of its own");
    } else if (model.hand >= 0 && !model.InSubtree(model.hand, body)) {
      wrong(joint, "does not move body \"hand\"",
            "attach the hand to the arm's last link, or take the joint out of \"arm_joints\"");
    } else if (i > 0 && !model.InSubtree(body, m.jnt_bodyid[model.arm_joints[i - 1]])) {
      wrong(joint,
            fmt::format("comes after \"{}\" in \"arm_joints\" and is not behind it",
                        model.Name(mjOBJ_JOINT, model.arm_joints[i - 1])),
            "list the joints from base to tip, and the actuators in the same order");
    }
  }
  if (!right || model.hand < 0) return right;
  for (int body = m.body_parentid[model.hand]; body > 0; body = m.body_parentid[body]) {
    if (m.body_jntnum[body] == 0) continue;
    const int joint = m.body_jntadr[body];
    if (std::find(model.arm_joints.begin(), model.arm_joints.end(), joint) !=
        model.arm_joints.end()) {
      continue;
    }
    wrong(joint, "lies between the world and the hand, and is not in \"arm_joints\"",
          "list it in \"arm_joints\" and its drive in \"arm_actuators\", or remove the joint");
  }
  return right;
}

void CheckCount(Model& model) {
  const int n = static_cast<int>(model.arm_joints.size());
  if (n >= kMinJoints && n <= kMaxJoints) return;
  const std::string what =
      fmt::format("has {} joints; it needs 6 or 7 to bring the hand to any pose", n);
  n < kMinJoints
      ? model.Error(model.ArmFile(), "the arm", what, "list all joints in \"arm_joints\"")
      : model.Warn(model.ArmFile(), "the arm", what, "remove joints that it can do without");
}

void CheckHome(Model& model) {
  const mjModel& m = model.m();
  std::string bad;
  std::string values;
  for (std::size_t i = 0; i < model.home.size(); ++i) {
    const int joint = model.arm_joints[i];
    const mjtNum* range = m.jnt_range + 2 * joint;
    double value = model.home[i];
    if (m.jnt_limited[joint] && !(value >= range[0] && value <= range[1])) {
      bad += fmt::format("{}{} is {:.4g}, its range {:.4g} to {:.4g}", bad.empty() ? "" : "; ",
                         model.Name(mjOBJ_JOINT, joint), value, range[0], range[1]);
      value = std::clamp(value, 0.9 * range[0] + 0.1 * range[1], 0.1 * range[0] + 0.9 * range[1]);
    }
    values += fmt::format("{}{:.4g}", values.empty() ? "" : " ", value);
  }
  if (bad.empty()) return;
  const int numeric = model.Find(mjOBJ_NUMERIC, "home");
  model.Error(model.Where(mjOBJ_NUMERIC, numeric), "numeric \"home\"",
              "lies outside the joints' ranges [rad]: " + bad,
              fmt::format("<numeric name=\"home\" data=\"{}\"/>", values));
}

std::string ServoBlock(const Model& model, int joint) {
  std::string name = model.Name(mjOBJ_JOINT, joint);
  name = name.substr(name.find_last_of('/') + 1);
  const std::string range = model.m().jnt_limited[joint] ? " inheritrange=\"1\"" : "";
  return fmt::format("<position joint=\"{}\" kp=\"5000\" dampratio=\"1\"{}/>", name, range);
}

void CheckDrive(Model& model, int joint, int actuator) {
  const mjModel& m = model.m();
  const mjtNum* gain = m.actuator_gainprm + actuator * mjNGAIN;
  const mjtNum* bias = m.actuator_biasprm + actuator * mjNBIAS;
  const std::string where = model.Where(mjOBJ_ACTUATOR, actuator);
  const std::string element = model.Element(mjOBJ_ACTUATOR, actuator);
  const std::string name = model.Name(mjOBJ_JOINT, joint);
  if (m.actuator_trntype[actuator] != mjTRN_JOINT || m.actuator_trnid[2 * actuator] != joint) {
    return model.Error(where, element, fmt::format("does not drive joint \"{}\"", name),
                       "list \"arm_actuators\" in the order of \"arm_joints\"");
  }
  if (m.actuator_biastype[actuator] != mjBIAS_AFFINE || !(gain[0] > 0.0) ||
      std::abs(bias[1] + gain[0]) > kSameGain * gain[0]) {
    return model.Error(where, element, "is no position servo",
                       "in its place " + ServoBlock(model, joint));
  }
  if (m.actuator_gear[6 * actuator] != 1.0) {
    return model.Error(where, element,
                       fmt::format("has a gear of {:g}, so that its command is no angle",
                                   m.actuator_gear[6 * actuator]),
                       "in its place " + ServoBlock(model, joint));
  }
  if (bias[2] == 0.0 && m.dof_damping[m.jnt_dofadr[joint]] == 0.0) {
    model.Error(where, element, "swings for ever: neither it nor its joint is damped",
                "dampratio=\"1\" in a <position>, or the third number of biasprm");
  }
  const mjtNum* command = m.actuator_ctrlrange + 2 * actuator;
  const mjtNum* range = m.jnt_range + 2 * joint;
  if (!m.actuator_ctrllimited[actuator]) return;
  const double low = m.jnt_limited[joint] ? range[0] : -2.0 * mjPI;
  const double high = m.jnt_limited[joint] ? range[1] : 2.0 * mjPI;
  if (command[0] <= low + kSameRange_rad && command[1] >= high - kSameRange_rad) return;
  model.Error(
      where, element,
      fmt::format("takes commands from {:.4g} to {:.4g} only, and joint \"{}\" turns from "
                  "{:.4g} to {:.4g}: motions are cut there",
                  command[0], command[1], name, low, high),
      fmt::format("ctrlrange=\"{:.6g} {:.6g}\", or the same range for the joint", low, high));
}

void CheckArmature(Model& model) {
  const mjModel& m = model.m();
  std::vector<int> light;
  for (const int joint : model.arm_joints) {
    if (m.dof_armature[m.jnt_dofadr[joint]] < kMinArmature) light.push_back(joint);
  }
  if (light.empty()) return;
  model.Error(model.Where(mjOBJ_JOINT, light.front()),
              "joints " + model.NamesOf(mjOBJ_JOINT, light),
              "have no armature (the inertia of motor and gear), or next to none: what the hand "
              "holds slips and sinks in",
              DefaultJoint(model, "armature=\"0.1\"") +
                  " (kg m^2; joints or classes with an armature of their own keep it)");
}

void CheckGravity(Model& model) {
  const mjModel& m = model.m();
  // What asks for it gets it once the hand is there.
  const auto asked = model.Numeric("gravity_compensation");
  if (model.hand < 0 && asked.size() == 1 && asked[0] != 0.0) return;
  std::vector<int> heavy;
  for (int body = 1; body < m.nbody; ++body) {
    if (model.IsRobot(body) && m.body_mass[body] > 0.0 && m.body_gravcomp[body] < kCompensated) {
      heavy.push_back(body);
    }
  }
  if (heavy.empty()) return;
  model.Error(model.Where(mjOBJ_BODY, heavy.front()), "bodies " + model.NamesOf(mjOBJ_BODY, heavy),
              "are not compensated for gravity, so that the arm sags",
              fmt::format("<numeric name=\"gravity_compensation\" data=\"1\"/> in the <custom> of "
                          "{}: the drives then carry arm and hand (or gravcomp=\"1\" on each body)",
                          model.ArmFile()));
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
    std::string block = "in <actuator>:";
    for (const int joint : model.arm_joints) block += "\n" + ServoBlock(model, joint);
    model.Error(model.ArmFile(), "the arm",
                fmt::format("does not have one drive for each of its {} joints in "
                            "\"arm_actuators\"",
                            model.arm_joints.size()),
                block + "\nand list them in the tuple \"arm_actuators\"");
  }
  CheckArmature(model);
  CheckGravity(model);
}

}  // namespace rangegrasp::check::internal
