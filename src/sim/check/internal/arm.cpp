#include "sim/check/internal/arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/words.h"
#include "robot/mjcf/hand.h"

namespace rangegrasp::check::internal {
namespace {

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
      fmt::format("has {} joints; it needs 6 or 7 to move the hand to any pose", n),
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

// A servo that keeps the file's force range and its own name.
std::string ServoBlock(const Model& model, int joint, int actuator) {
  const mjModel& m = model.m();
  const std::string name(mjcf::Suffix(model.Name(mjOBJ_JOINT, joint)));
  std::string block = fmt::format(
      "<position name=\"{}\" joint=\"{}\" kp=\"5000\" dampratio=\"1\"{}",
      actuator < 0 ? "servo_" + name : mjcf::Suffix(model.Name(mjOBJ_ACTUATOR, actuator)), name,
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
      model.Where(mjOBJ_JOINT, light.front()), "joints " + model.NamesOf(mjOBJ_JOINT, light),
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
  for (int body = 1; body < m.nbody; ++body) {
    if (model.IsRobot(body) && m.body_mass[body] > 0.0 && m.body_gravcomp[body] < kCompensated) {
      heavy.push_back(body);
    }
  }
  if (heavy.empty()) return;
  model.Error(model.Where(mjOBJ_BODY, heavy.front()), "bodies " + model.NamesOf(mjOBJ_BODY, heavy),
              "are not compensated for gravity, so that the arm sags",
              model.SetNumeric("gravity_compensation", "1", model.ArmFile()) +
                  ": the drives then carry arm and hand (or gravcomp=\"1\" on each body)");
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

}  // namespace rangegrasp::check::internal
