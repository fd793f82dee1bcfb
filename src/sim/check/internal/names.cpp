// Names, tuples and numerics that the program looks for.

#include <fmt/format.h>

#include <algorithm>

#include "base/words.h"
#include "sim/check/internal/hand.h"
#include "sim/check/internal/model.h"
#include "sim/check/internal/view.h"

namespace rangegrasp::check::internal {
namespace {

// A block to paste, with the elements that are likely to be meant.
std::string TupleBlock(const Model& model, const std::string& tuple, mjtObj type,
                       const std::vector<int>& ids) {
  std::string text = fmt::format("in <custom>:\n<tuple name=\"{}\">\n", tuple);
  for (const int id : ids) {
    std::string name = model.Name(type, id);
    // Within its own file an element goes without the prefixes of attachments.
    name = name.substr(name.find_last_of('/') + 1);
    text += fmt::format("  <element objtype=\"{}\" objname=\"{}\"/>\n", mju_type2Str(type),
                        name.empty() ? "NAME" : name);
  }
  if (ids.empty()) {
    text += fmt::format("  <element objtype=\"{}\" objname=\"NAME\"/>\n", mju_type2Str(type));
  }
  return text + "</tuple>";
}

struct Wanted {
  mjtObj type;
  const char* name;
  bool needed;
  const char* what_for;
  const char* cure;
};

// Whether it is there once; adds what is wrong.
bool CheckOne(Model& model, const Wanted& wanted, const std::string& file) {
  const auto found = model.FindAll(wanted.type, wanted.name);
  const std::string element = fmt::format("{} \"{}\"", mju_type2Str(wanted.type), wanted.name);
  if (found.size() > 1) {
    model.Error(model.Where(wanted.type, found[1]), element,
                fmt::format("is there twice: {}", model.NamesOf(wanted.type, found)),
                "rename or remove one of them");
    return false;
  }
  if (!found.empty()) return true;
  const std::string what = fmt::format("is missing: {}", wanted.what_for);
  wanted.needed ? model.Error(file, element, what, wanted.cure)
                : model.Warn(file, element, what, wanted.cure);
  return false;
}

void CheckSceneNames(Model& model) {
  const std::string file = model.file().string();
  for (const Wanted& wanted :
       {Wanted{mjOBJ_SITE, "workspace", true, "objects are put and looked for there",
               "<site name=\"workspace\" type=\"cylinder\" size=\"0.13 0.0005\" group=\"4\"/> on "
               "the table's top (z = 0); its first size is the radius"},
        Wanted{mjOBJ_SITE, "delivery", true, "objects are carried there",
               "<site name=\"delivery\" type=\"cylinder\" pos=\"-0.08 -0.42 0\" size=\"0.15 "
               "0.0005\" group=\"4\"/> on the table's top"},
        Wanted{mjOBJ_SITE, "scanner", true, "the sensor looks from there",
               "<site name=\"scanner\" group=\"4\"/> with x to the right, y down, z to the "
               "workspace, as in scenes/tabletop.xml"},
        Wanted{mjOBJ_CAMERA, "overview", false, "`snapshot` draws from it",
               "copy it from scenes/tabletop.xml"},
        Wanted{mjOBJ_CAMERA, "close", false, "`trial --snapshots` looks along it",
               "copy it from scenes/tabletop.xml"}}) {
    CheckOne(model, wanted, file);
  }
}

void CheckTuple(Model& model, const std::string& file, const char* name, mjtObj type,
                const char* what_for, const std::vector<int>& likely) {
  const std::string cure = TupleBlock(model, name, type, likely);
  if (!CheckOne(model, {mjOBJ_TUPLE, name, true, what_for, cure.c_str()}, file)) return;
  if (!model.Tuple(name, type).empty()) return;
  model.Error(
      model.Where(mjOBJ_TUPLE, model.Find(mjOBJ_TUPLE, name)), fmt::format("tuple \"{}\"", name),
      fmt::format("holds something else than elements of type {}", mju_type2Str(type)), cure);
}

// A numeric of so many values above 0 (or any).
void CheckNumeric(Model& model, const std::string& file, const Wanted& wanted, std::size_t size,
                  bool positive) {
  if (!CheckOne(model, wanted, file)) return;
  const auto values = model.Numeric(wanted.name);
  const bool right =
      values.size() == size &&
      (!positive || std::all_of(values.begin(), values.end(), [](double v) { return v > 0.0; }));
  if (right) return;
  model.Error(model.Where(mjOBJ_NUMERIC, model.Find(mjOBJ_NUMERIC, wanted.name)),
              fmt::format("numeric \"{}\"", wanted.name),
              fmt::format("should hold {} {}, it holds {}", size,
                          positive ? "numbers above 0" : "numbers", values.size()),
              wanted.cure);
}

std::string NumericBlock(const char* name, std::size_t count, const char* value) {
  std::vector<std::string> values(count, value);
  return fmt::format("in <custom>: <numeric name=\"{}\" data=\"{}\"/>", name,
                     base::Join(values, " "));
}

void CheckArmNames(Model& model) {
  const std::string file = model.ArmFile();
  CheckTuple(model, file, "arm_joints", mjOBJ_JOINT, "the arm's joints, base to tip",
             model.arm_joints);
  CheckTuple(model, file, "arm_actuators", mjOBJ_ACTUATOR,
             "the position servos of these joints, in the same order", model.arm_actuators);
  const std::size_t n = model.arm_joints.size();
  const std::string velocity =
      NumericBlock("joint_velocity", n, "1") + ", or what the data sheet says, one a joint";
  const std::string acceleration =
      NumericBlock("joint_acceleration", n, "2") + ", or what the data sheet says, one a joint";
  const std::string suggested = SuggestHome(model);
  const std::string home =
      suggested.empty()
          ? NumericBlock("home", n, "0") +
                ", in the arm's file or the scene's: the check of the scene proposes one"
          : "in <custom>: " + suggested;
  CheckNumeric(model, file,
               {mjOBJ_NUMERIC, "joint_velocity", true, "limits in rad/s", velocity.c_str()}, n,
               true);
  CheckNumeric(
      model, file,
      {mjOBJ_NUMERIC, "joint_acceleration", true, "limits in rad/s^2", acceleration.c_str()}, n,
      true);
  CheckNumeric(model, file,
               {mjOBJ_NUMERIC, "home", model.kind() == Kind::kScene, "where the arm waits [rad]",
                home.c_str()},
               n, false);
}

// Which of the two kinds of hands it is to be: one geared motor on hinges, or drives that say how
// they close it.
bool IsGeared(const Model& model) {
  return model.Find(mjOBJ_TUPLE, "hand_motors") < 0 &&
         (model.Find(mjOBJ_TUPLE, "hand_motor") >= 0 ||
          model.Find(mjOBJ_TUPLE, "hand_joints") >= 0);
}

void CheckGearedNames(Model& model, const std::string& file) {
  CheckTuple(model, file, "hand_joints", mjOBJ_JOINT, "the driven joints, the thumb's first", {});
  CheckTuple(model, file, "hand_motor", mjOBJ_ACTUATOR, "what closes them", {});
  CheckTuple(model, file, "fingertips", mjOBJ_GEOM, "the geoms that may hold an object", {});
}

void CheckMotorNames(Model& model, const std::string& file) {
  const HandGuess guess = GuessHand(model);
  CheckTuple(model, file, "hand_motors", mjOBJ_ACTUATOR, "the drives that close the hand",
             guess.motors);
  CheckTuple(model, file, "fingertips", mjOBJ_GEOM,
             "the geoms that may hold an object, the thumb's first (geoms need names)",
             guess.fingertips);
  const auto ends = [&](const char* name, const char* what, const std::string& values) {
    const std::string cure = fmt::format("in <custom>: <numeric name=\"{}\" data=\"{}\"/>", name,
                                         values.empty() ? "VALUE ..." : values);
    const std::size_t drives = model.Tuple("hand_motors", mjOBJ_ACTUATOR).size();
    CheckNumeric(model, file, {mjOBJ_NUMERIC, name, true, what, cure.c_str()},
                 drives > 0 ? drives : guess.motors.size(), false);
  };
  ends("hand_open", "where each drive's joint or tendon stands in the open hand [rad or m]",
       guess.open);
  ends("hand_closed", "where it stands in the closed hand", guess.closed);
  CheckNumeric(model, file,
               {mjOBJ_NUMERIC, "grip_force", true,
                "the first grip and the strongest one between the two sides [N]",
                "in <custom>: <numeric name=\"grip_force\" data=\"20 40\"/>"},
               2, true);
}

void CheckToolSites(Model& model, const std::string& file) {
  const bool own = model.Find(mjOBJ_SITE, "tcp_tip") >= 0 || IsGeared(model);
  const std::string cure =
      own ? "a <site> of this name in the body \"hand\", between the tips of the open hand"
          : SuggestTool(model);
  const char* what =
      "the tool's centre: z is the approach, x leads from the fingers' pads to the thumb's";
  if (!own) CheckOne(model, {mjOBJ_SITE, "tcp", true, what, cure.c_str()}, file);
  for (const char* site : {"tcp_tip", "tcp_power"}) {
    if (own) CheckOne(model, {mjOBJ_SITE, site, true, what, cure.c_str()}, file);
  }
}

void CheckHandNames(Model& model) {
  const std::string file = model.HandFile();
  const char* attach =
      "attach a hand to the last link, e.g. in <asset> <model name=\"hand\" "
      "file=\"PATH/models/hand/sensorhand.xml\"/> and in the last body\n"
      "<frame pos=\"FLANGE\" xyaxes=\"0 1 0 0 0 1\">\n"
      "  <frame pos=\"-0.010 0.075 -0.020\">\n"
      "    <attach model=\"hand\" body=\"hand\" prefix=\"hand/\"/>\n"
      "  </frame>\n"
      "</frame>\n"
      "where FLANGE is the place of the flange, its axis z";
  const std::string rename =
      model.kind() == Kind::kHand && model.m().nbody > 1
          ? fmt::format("name=\"hand\" in place of \"{}\"", model.BodyName(1))
          : attach;
  if (!CheckOne(model, {mjOBJ_BODY, "hand", true, "the hand's root", rename.c_str()},
                model.HasArm() ? model.ArmFile() : file)) {
    if (model.kind() != Kind::kHand || model.m().nbody < 2) return;
    model.hand = 1;  // what else it lacks is said at once
  }
  IsGeared(model) ? CheckGearedNames(model, file) : CheckMotorNames(model, file);
  CheckToolSites(model, file);
  CheckOne(model,
           {mjOBJ_TUPLE, "grip_sensors", false, "the hand feels neither pressure nor slip",
            "<touch> sensors on the last segments, named in a tuple of this name"},
           file);
}

}  // namespace

void CheckNames(Model& model) {
  if (model.kind() == Kind::kScene) CheckSceneNames(model);
  if (model.HasArm()) CheckArmNames(model);
  CheckHandNames(model);
}

}  // namespace rangegrasp::check::internal
