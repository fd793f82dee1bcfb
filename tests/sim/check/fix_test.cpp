#include "sim/check/fix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "base/file.h"
#include "base/words.h"
#include "hand_cell.h"
#include "robot/mjcf/hand.h"
#include "sim/check/check.h"
#include "sim/check/findings.h"
#include "temp_folder.h"

// One edit breaks a good file. The edits of the finding fix it and change nothing else in the file.

namespace rangegrasp::check {
namespace {

using testing::HasSubstr;
using testing_support::ExampleHand;
using testing_support::TempFolder;
using testing_support::TextOfAll;

const std::filesystem::path kProject = RANGEGRASP_SOURCE_DIR;

struct Fault {
  const char* name;
  const char* file;
  const char* from;  // a regular expression
  const char* to;
  const char* found;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class Files : public testing::Test {
 protected:
  void Break(const std::string& file, const std::string& from, const std::string& to) {
    const std::string before = files_.at(file);
    files_[file] =
        std::regex_replace(before, std::regex(from), to, std::regex_constants::format_first_only);
    ASSERT_NE(files_[file], before) << from;
  }
  std::filesystem::path Write(const std::string& main) {
    for (const auto& [name, text] : files_) base::WriteFile(folder_ / name, text);
    return folder_ / main;
  }
  std::vector<base::Finding> Cure(Fixer& fixer, Kind kind) {
    auto findings = CheckModel(fixer.file(), kind);
    fixer.Run(findings, [&] { return findings = CheckModel(fixer.file(), kind); });
    return findings;
  }
  // Whether an edit of this file replaced the line, or the lines of which it is one.
  static bool IsEdited(const Fixer& fixer, const std::filesystem::path& file,
                       const std::string& line) {
    const std::size_t tag = line.find_first_not_of(' ');
    return std::ranges::any_of(fixer.changes(), [&](const Change& c) {
      if (c.file != file || c.before.empty()) return false;  // an insertion replaces no line
      return line.find(c.before.substr(0, c.before.find('\n'))) != std::string::npos ||
             (tag != std::string::npos && c.before.find(line.substr(tag)) != std::string::npos);
    });
  }
  // Lines that no edit names are unchanged and in order.
  void ExpectTheRestUnchanged(const Fixer& fixer) {
    for (const auto& [name, text] : files_) {
      EXPECT_EQ(base::ReadFile(folder_ / name), text) << "the original " << name;
      const auto copy = folder_ / (std::filesystem::path(name).stem().string() + ".fixed.xml");
      if (!std::filesystem::exists(copy)) continue;
      const auto lines = base::Split(base::ReadFile(copy), '\n');
      auto at = lines.begin();
      for (const std::string& line : base::Split(text, '\n')) {
        const auto found = std::find(at, lines.end(), line);
        if (found != lines.end()) {
          at = found + 1;
          continue;
        }
        EXPECT_TRUE(IsEdited(fixer, copy, line)) << name << ": " << line;
      }
    }
  }
  void ExpectCured(const Fault& fault, const std::string& main, Kind kind) {
    Break(fault.file, fault.from, fault.to);
    const auto file = Write(main);
    EXPECT_THAT(TextOfAll(CheckModel(file, kind)), HasSubstr(fault.found));
    Fixer fixer(file, /*in_place=*/false);
    const auto left = Cure(fixer, kind);
    EXPECT_TRUE(left.empty()) << TextOfAll(left);
    EXPECT_FALSE(fixer.changes().empty());
    EXPECT_NE(fixer.file(), file);
    ExpectTheRestUnchanged(fixer);
  }

  TempFolder folder_;
  std::map<std::string, std::string> files_;
};

// A scene of an arm with the shipped hand.
class FixedScene : public Files, public testing::WithParamInterface<Fault> {
 protected:
  void SetUp() override {
    const auto read = [](const char* file) { return base::ReadFile(kProject / file); };
    files_ = {{"hand.xml", read("models/hand/sensorhand.xml")},
              {"bench.xml", read("scenes/bench.xml")},
              {"arm.xml", read("tests/data/arms/seven_joints.xml")},
              {"scene.xml", read("tests/data/arms/seven_on_pedestal.xml")}};
    Break("arm.xml", "../../../models/hand/sensorhand.xml", "hand.xml");
    Break("scene.xml", "../../../scenes/bench.xml", "bench.xml");
    Break("scene.xml", "seven_joints.xml", "arm.xml");
  }
};

// Only what is soft is proposed: parallel_jaw.xml is firm already, the shipped hand's coupling
// less.
TEST(Firmer, IsEmptyWhereTheModelIsFirm) {
  const TempFolder folder;
  const auto scene = testing_support::WriteHandCell(folder, ExampleHand("parallel_jaw"));
  EXPECT_EQ(FirmerEqualities(scene), "");
  EXPECT_EQ(FirmerTips(scene), "");
  std::string soft = ExampleHand("parallel_jaw");
  for (const char* firm :
       {" solref=\"0.005 1\" solimp=\"0.999 0.9999 0.001 0.5 2\"", "priority=\"1\" "}) {
    ASSERT_NE(soft.find(firm), std::string::npos) << firm;
    soft.replace(soft.find(firm), std::string(firm).size(), "");
  }
  testing_support::WriteHandCell(folder, soft);
  EXPECT_EQ(FirmerEqualities(scene), "solref=\"0.005 1\" solimp=\"0.999 0.9999 0.001\"");
  EXPECT_EQ(FirmerTips(scene), "priority=\"1\"");
}

TEST_P(FixedScene, IsCured) { ExpectCured(GetParam(), "scene.xml", Kind::kScene); }

INSTANTIATE_TEST_SUITE_P(
    OneFault, FixedScene,
    testing::Values(
        Fault{"Workspace", "bench.xml", "<site name=\"workspace\"[^>]*/>", "",
              "site \"workspace\""},
        Fault{"WorkspaceShape", "bench.xml", "<site name=\"workspace\" type=\"cylinder\"",
              "<site name=\"workspace\" type=\"box\"", "is not a cylinder"},
        Fault{"Camera", "bench.xml", "<camera name=\"overview\"", "<camera name=\"over\"",
              "camera \"overview\""},
        Fault{"ArmJoints", "arm.xml", "<tuple name=\"arm_joints\">[^]*?</tuple>", "",
              "tuple \"arm_joints\""},
        Fault{"TupleOfBodies", "arm.xml", "objtype=\"actuator\" objname=\"drive3\"",
              "objtype=\"body\" objname=\"link3\"", "must have only elements of type actuator"},
        Fault{"DrivesInAnotherOrder", "arm.xml", "(objname=\"drive2\")([^]*)(objname=\"drive3\")",
              "$3$2$1", "does not drive joint"},
        Fault{"TooFewVelocities", "arm.xml", "data=\"2 2 2 2 2.5 2.5 2.5\"", "data=\"2 2 2\"",
              "numeric \"joint_velocity\""},
        Fault{"NoAcceleration", "arm.xml", "<numeric name=\"joint_acceleration\"[^>]*/>", "",
              "numeric \"joint_acceleration\""},
        Fault{"NoServo", "arm.xml", "<position name=\"drive4\"", "<motor name=\"drive4\"",
              "is not a position servo"},
        Fault{"UnnamedDrive", "arm.xml", "<position name=\"drive4\"", "<motor",
              "unnamed actuator of joint"},
        Fault{"CutCommand", "arm.xml", "joint=\"joint2\" f",
              "joint=\"joint2\" ctrlrange=\"-1 1\" f", "commands from -1 to 1 only"},
        Fault{"Armature", "arm.xml", " armature=\"0.1\"", "", "too little armature"},
        Fault{"Gravity", "arm.xml", "<numeric name=\"gravity_compensation\" data=\"1\"/>", "",
              "not compensated for gravity"},
        Fault{"SlowDrive", "arm.xml", "joint=\"joint1\" f", "joint=\"joint1\" kp=\"400\" f",
              "mrad behind"},
        Fault{"Spring", "arm.xml", "<joint name=\"joint2\"",
              "<joint name=\"joint2\" stiffness=\"300\" springref=\"0\"",
              "does not hold the arm at home"},
        Fault{"LinksThatTouch", "arm.xml", "fromto=\"0 0 -0.06 0.08 0 0\"",
              "fromto=\"0 0 -0.3 0.08 0 0\"", "touch"},
        Fault{"Home", "scene.xml", "<numeric name=\"home\"[^>]*/>", "", "numeric \"home\""},
        Fault{"HomeOutOfRange", "scene.xml", "-1.67", "0", "outside the joints' ranges"},
        Fault{"HomeInView", "scene.xml", "data=\"[^\"]*\"", "data=\"0 0.3 0 -1.6 0 1.3 0\"",
              "numeric \"home\": body"},
        Fault{"Cones", "bench.xml", "cone=\"elliptic\"", "cone=\"pyramidal\"",
              "pyramidal friction cones"}),
    [](const auto& tested) { return tested.param.name; });

class FixedHand : public Files, public testing::WithParamInterface<Fault> {
 protected:
  void SetUp() override { files_ = {{"hand.xml", ExampleHand("parallel_jaw")}}; }
};

TEST_P(FixedHand, IsCured) { ExpectCured(GetParam(), "hand.xml", Kind::kHand); }

INSTANTIATE_TEST_SUITE_P(
    OneFault, FixedHand,
    testing::Values(Fault{"Root", "hand.xml",
                          "name=\"hand\"([^]*)body1=\"hand\"([^]*)body1=\"hand\"",
                          "name=\"jaws\"$1body1=\"jaws\"$2body1=\"jaws\"", "body \"hand\""},
                    Fault{"Motors", "hand.xml", "<tuple name=\"hand_motors\">[^]*?</tuple>", "",
                          "tuple \"hand_motors\""},
                    Fault{"Fingertips", "hand.xml", "<tuple name=\"fingertips\">[^]*?</tuple>", "",
                          "tuple \"fingertips\""},
                    Fault{"Open", "hand.xml", "<numeric name=\"hand_open\"[^>]*/>", "",
                          "numeric \"hand_open\""},
                    Fault{"Closed", "hand.xml", "<numeric name=\"hand_closed\"[^>]*/>", "",
                          "numeric \"hand_closed\""},
                    Fault{"TwoValuesOfOneDrive", "hand.xml", "name=\"hand_closed\" data=\"0\"",
                          "name=\"hand_closed\" data=\"0 0\"", "must have 1 numbers"},
                    Fault{"Swapped", "hand.xml", "hand_open([^]*)hand_closed",
                          "hand_closed$1hand_open", "move apart while the hand closes"},
                    Fault{"StopsShort", "hand.xml", "name=\"hand_closed\" data=\"0\"",
                          "name=\"hand_closed\" data=\"-0.02\"", "short of \"hand_closed\""},
                    Fault{"Force", "hand.xml", "<numeric name=\"grip_force\"[^>]*/>", "",
                          "numeric \"grip_force\""},
                    Fault{"WeakDrive", "hand.xml", "forcerange=\"-200 200\"",
                          "forcerange=\"-60 60\"", "gives 30 N"},
                    Fault{"WeakServo", "hand.xml", "kp=\"5000\" dampratio=\"1\"",
                          "kp=\"1000\" kv=\"50\" ctrlrange=\"0 0.05\"", "N between the pads"},
                    Fault{"Tool", "hand.xml", "<site name=\"tcp\"[^>]*/>", "", "site \"tcp\""},
                    Fault{"ToolTheWrongWay", "hand.xml", "<site name=\"tcp\"",
                          "<site name=\"tcp\" xyaxes=\"-1 0 0 0 -1 0\"", "from the thumb's pads"},
                    Fault{"SoftPads", "hand.xml",
                          "(condim=\"4\" friction=\"0.5 0.005 0.0001\" solref=\")0.005", "$010.02",
                          "contacts are soft"},
                    Fault{"PadsWithoutContact", "hand.xml", "<geom name=\"thumb_pad\"",
                          "<geom name=\"thumb_pad\" contype=\"0\" conaffinity=\"0\"",
                          "is a fingertip, but not a collision geom"}),
    [](const auto& tested) { return tested.param.name; });

TEST_F(FixedHand, WithoutFaultHasNoCopy) {
  const auto file = Write("hand.xml");
  Fixer fixer(file, /*in_place=*/false);
  EXPECT_FALSE(fixer.Apply(CheckModel(file, Kind::kHand)));
  EXPECT_EQ(fixer.file(), file);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "hand.fixed.xml"));
}

TEST_F(FixedHand, InPlaceKeepsTheBytesOfEachTime) {
  Break("hand.xml", "condim=\"4\"", "condim=\"3\"");
  const auto file = Write("hand.xml");
  Fixer fixer(file, /*in_place=*/true);
  EXPECT_TRUE(Cure(fixer, Kind::kHand).empty());
  EXPECT_EQ(fixer.file(), file);
  EXPECT_EQ(base::ReadFile(folder_ / "hand.xml.bak"), files_.at("hand.xml"));
  EXPECT_THAT(
      base::ReadFile(file),
      HasSubstr(
          "<geom name=\"thumb_pad\" class=\"jaw_pad\" pos=\"-0.004 0 0.060\" condim=\"4\"/>"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "hand.fixed.xml"));
  Break("hand.xml", "condim=\"3\"", "condim=\"1\"");
  Write("hand.xml");
  EXPECT_TRUE(Fixer(file, /*in_place=*/true).Apply(CheckModel(file, Kind::kHand)));
  EXPECT_EQ(base::ReadFile(folder_ / "hand.xml.bak2"), files_.at("hand.xml"));
  EXPECT_NE(base::ReadFile(folder_ / "hand.xml.bak"), files_.at("hand.xml")) << "still the first";
}

// Every finger segment has its own drive. For the file without poses, the poses found are those
// where the pads meet.
TEST_F(FixedHand, FindsThePosesOfFingersWithSeveralDrives) {
  files_ = {{"hand.xml", ExampleHand("three_fingers")}};
  Break("hand.xml", "<equality>[^]*?</equality>", "");
  std::string motors, elements;
  for (const std::string finger : {"thumb", "left", "right"}) {
    motors += "<motor name=\"" + finger + "_tip_motor\" joint=\"" + finger +
              "_tip\" ctrlrange=\"-6 6\"/>";
    elements += "<element objtype=\"actuator\" objname=\"" + finger + "_tip_motor\"/>";
  }
  Break("hand.xml", "</actuator>", motors + "</actuator>");
  Break("hand.xml", "(objname=\"right_motor\"/>)", "$1" + elements);
  Break("hand.xml", "<numeric name=\"hand_open\"[^>]*/>", "");
  Break("hand.xml", "<numeric name=\"hand_closed\"[^>]*/>", "");
  Fixer fixer(Write("hand.xml"), /*in_place=*/false);
  const auto left = Cure(fixer, Kind::kHand);
  EXPECT_TRUE(left.empty()) << TextOfAll(left);
  const mjcf::ModelPtr model(mj_loadXML(fixer.file().c_str(), nullptr, nullptr, 0));
  const auto closing = mjcf::CloseOnNothing(model.get(), mjcf::HandMotors(model.get()));
  EXPECT_GT(closing.points.front().gap_m, 0.08);  // 0.1 between the tips' centers
  EXPECT_LT(closing.points.back().gap_m, 0.001);
}

// A hand without any of the names, with soft servos without armature and overlapping links.
TEST_F(FixedHand, FindsAllOfAFourFingeredHand) {
  files_ = {{"hand.xml", base::ReadFile(kProject / "tests/data/hands/four_fingers.xml")}};
  Fixer fixer(Write("hand.xml"), /*in_place=*/false);
  const auto left = Cure(fixer, Kind::kHand);
  ASSERT_EQ(left.size(), 1u) << TextOfAll(left);
  EXPECT_THAT(TextOfAll(left), HasSubstr("grip_sensors"));
  const mjcf::ModelPtr model(mj_loadXML(fixer.file().c_str(), nullptr, nullptr, 0));
  const mjModel* m = model.get();
  const auto motors = mjcf::HandMotors(m);
  const auto closing = mjcf::CloseOnNothing(m, motors);
  EXPECT_NEAR(closing.points.front().gap_m, 0.1, 0.003);
  EXPECT_LT(closing.points.back().gap_m, 0.0);
  const mjcf::DataPtr data(mj_makeData(m));
  const auto place = [&](const std::string& geom) {
    return Eigen::Vector3d(mjcf::Vec3(data->geom_xpos + 3 * mjcf::Find(m, mjOBJ_GEOM, geom)));
  };
  for (const double share : {0.0, 0.5, 1.0}) {
    closing.Pose(m, data.get(), share);
    mj_kinematics(m, data.get());
    const base::Pose X_TW = mjcf::SitePose(data.get(), mjcf::Find(m, mjOBJ_SITE, "tcp")).inverse();
    const Eigen::Vector3d first = X_TW * place("if_tip"), last = X_TW * place("rf_tip");
    EXPECT_NEAR(first.x(), last.x(), 0.006) << "a straight row at " << share;
    const double middle = 0.5 * (first.y() + last.y());
    EXPECT_NEAR((X_TW * place("th_tip")).y(), middle, 0.02) << "at " << share;
  }
  // In the open hand, the last segments are parallel to the approach direction.
  closing.Pose(m, data.get(), 0.0);
  mj_kinematics(m, data.get());
  const auto tool = mjcf::SitePose(data.get(), mjcf::Find(m, mjOBJ_SITE, "tcp")).linear();
  for (const char* tip : {"th_tip", "if_tip", "mf_tip", "rf_tip"}) {
    const int geom = mjcf::Find(m, mjOBJ_GEOM, tip);
    const Eigen::Vector3d along = mjcf::Mat3(data->geom_xmat + 9 * geom).col(2);
    EXPECT_LT(std::abs(along.dot(tool.col(0))), std::sin(15.0 * mjPI / 180.0)) << tip;
  }
  for (int j = 0; j < m->njnt; ++j) EXPECT_GT(m->dof_damping[m->jnt_dofadr[j]], 0.0);
  // In a cell, the fingers are children of a moving palm, which they pass without contact.
  mj_forward(m, data.get());
  const int palm = mjcf::Find(m, mjOBJ_BODY, "hand");
  for (int i = 0; i < data->ncon; ++i) {
    const int* geoms = data->contact[i].geom;
    EXPECT_TRUE(m->geom_bodyid[geoms[0]] == palm || m->geom_bodyid[geoms[1]] == palm)
        << mjcf::NameOf(m, mjOBJ_BODY, m->geom_bodyid[geoms[0]]) << " and "
        << mjcf::NameOf(m, mjOBJ_BODY, m->geom_bodyid[geoms[1]]);
  }
}

// Without an arm, the number of its speed limits is not known.
TEST(Fixer, WritesNoValuesThatItDoesNotKnow) {
  const TempFolder folder;
  const auto file = folder.Write("odd.xml",
                                 "<mujoco><worldbody><body name='odd'><geom size='0.02' "
                                 "mass='0.1'/></body></worldbody></mujoco>");
  ASSERT_EQ(KindOf(file), Kind::kScene);
  auto findings = CheckModel(file, Kind::kScene);
  EXPECT_THAT(TextOfAll(findings), HasSubstr("lacks a <freejoint/>; use --as object"));
  const auto before = findings.size();
  Fixer fixer(file, /*in_place=*/false);
  fixer.Run(findings, [&] { return findings = CheckModel(fixer.file(), Kind::kScene); });
  EXPECT_THAT(base::ReadFile(fixer.file()), testing::Not(HasSubstr("data=\"\"")));
  EXPECT_LT(findings.size(), before);
  EXPECT_THAT(TextOfAll(findings), HasSubstr("numeric \"joint_velocity\": is missing"));
}

// The layout around an edit stays unchanged.
TEST(ApplyEdit, KeepsAllOtherBytes) {
  const std::string text =
      "<!-- <joint name='a'/> -->\n<mujoco>\n\t<worldbody>\n\t\t<joint  name='a'\n\t\t\trange=\"0 "
      "> 1\"  />"
      "<!-- b -->\n\t</worldbody>\n  <custom/></mujoco>\n";
  const auto edited = [&](const base::Edit& edit) {
    std::string copy = text;
    ApplyEdit(edit, copy);
    return copy;
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string copy = text;
    return copy.replace(copy.find(from), from.size(), to);
  };
  const std::string joint = "//worldbody//joint[@name='a']";
  EXPECT_EQ(edited({.file = "", .element = joint, .set = {{"range", "0 2"}}}),
            replaced("range=\"0 > 1\"", "range=\"0 2\""));
  EXPECT_EQ(edited({.file = "", .element = joint, .set = {{"damping", "1"}}}),
            replaced("1\"  />", "1\" damping=\"1\"  />"));
  EXPECT_EQ(edited({.file = "", .element = joint, .set = {{"range", ""}}}),
            replaced("\n\t\t\trange=\"0 > 1\"", "\n\t\t"));
  EXPECT_EQ(edited({.file = "", .element = joint, .block = "<joint/>", .replace = true}),
            replaced("<joint  name='a'\n\t\t\trange=\"0 > 1\"  />", "<joint/>"));
  EXPECT_EQ(edited({.file = "", .element = "/*/worldbody", .block = "<a>\n</a>"}),
            replaced("<worldbody>", "<worldbody>\n\t\t<a>\n\t\t</a>"));
  EXPECT_EQ(edited({.file = "", .element = "/*/custom", .block = "<a/>"}),
            replaced("<custom/>", "<custom>\n    <a/>\n  </custom>"));
  EXPECT_EQ(edited({.file = "", .element = "/*/option", .set = {{"cone", "elliptic"}}}),
            replaced("</mujoco>", "  <option cone=\"elliptic\"/>\n</mujoco>"));
  EXPECT_EQ(edited({.file = "", .element = "//joint[@name='b']", .set = {{"range", "0 2"}}}), text);
}

}  // namespace
}  // namespace rangegrasp::check
