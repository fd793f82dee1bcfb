#include "sim/check/check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "base/error.h"
#include "base/file.h"
#include "error_of.h"
#include "labelled_cloud.h"
#include "sim/check/findings.h"
#include "temp_folder.h"

// For every finding, one edit of a good scene causes this finding and no other, so undoing the edit
// is its cure.

namespace rangegrasp::check {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing_support::TempFolder;
using testing_support::TextOfAll;

const std::filesystem::path kSource = RANGEGRASP_SOURCE_DIR;
const std::filesystem::path kArms = kSource / "tests/data/arms";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A user's cell in its own folder: bench.xml, an arm and a hand, joined by scene.xml.
class OwnCell : public testing::Test {
 protected:
  explicit OwnCell(const std::string& scene = "seven_on_pedestal",
                   const std::string& arm = "seven_joints") {
    hand_ = base::ReadFile(kSource / "models/hand/sensorhand.xml");
    arm_ = Replaced(base::ReadFile(kArms / (arm + ".xml")), "../../../models/hand/sensorhand.xml",
                    "hand.xml");
    scene_ = Replaced(base::ReadFile(kArms / (scene + ".xml")), "../../../scenes/bench.xml",
                      "bench.xml");
    scene_ = Replaced(scene_, arm + ".xml", "arm.xml");
    bench_ = base::ReadFile(kSource / "scenes/bench.xml");
  }
  std::filesystem::path Write() {
    base::WriteFile(folder_ / "hand.xml", hand_);
    base::WriteFile(folder_ / "arm.xml", arm_);
    base::WriteFile(folder_ / "bench.xml", bench_);
    base::WriteFile(folder_ / "scene.xml", scene_);
    return folder_ / "scene.xml";
  }
  std::vector<base::Finding> Check() { return CheckModel(Write(), Kind::kScene); }
  void SetHome(const std::string& values) {
    scene_ = std::regex_replace(scene_, std::regex("name=\"home\" data=\"[^\"]*\""),
                                "name=\"home\" data=\"" + values + "\"");
  }
  void ExpectOne(const std::vector<std::string>& words, bool error = true) {
    testing_support::ExpectOneFinding(Check(), words, error);
  }

  TempFolder folder_;
  std::string hand_, arm_, scene_, bench_;
};

class OwnCellOfSix : public OwnCell {
 protected:
  OwnCellOfSix() : OwnCell("six_on_pedestal", "six_joints") {}
};

TEST_F(OwnCell, WithoutFaultHasNoFinding) { EXPECT_EQ(TextOfAll(Check()), ""); }
TEST_F(OwnCellOfSix, WithoutFaultHasNoFinding) { EXPECT_EQ(TextOfAll(Check()), ""); }
TEST(CheckModel, FindsNothingInTheShippedScenesAndTheCellsOfOtherArms) {
  for (const char* scene :
       {"scenes/tabletop.xml", "scenes/tabletop_box.xml", "scenes/tabletop_box_wrist.xml",
        "tests/data/arms/six_on_wall.xml", "tests/data/arms/seven_on_ceiling.xml",
        "tests/data/arms/seven_on_floor.xml", "tests/data/arms/gen3_on_bench.xml",
        "tests/data/arms/ur3e_on_bench.xml"}) {
    for (const auto& finding : CheckModel(kSource / scene, Kind::kScene)) {
      ADD_FAILURE() << scene << ": " << base::TextOf(finding);
    }
  }
}

TEST(KindOf, IsWhatTheFileHolds) {
  EXPECT_EQ(KindOf(kSource / "scenes/tabletop.xml"), Kind::kScene);
  EXPECT_EQ(KindOf(kArms / "six_on_wall.xml"), Kind::kScene);
  EXPECT_EQ(KindOf(kSource / "models/arm/lwa3.xml"), Kind::kArm);
  EXPECT_EQ(KindOf(kSource / "models/hand/sensorhand.xml"), Kind::kHand);
  EXPECT_EQ(KindOf(kSource / "models/objects/spread/spread.xml"), Kind::kObject);
  EXPECT_THROW(KindOf("no_such_file.xml"), base::InputError);
}

// A recursion over so many would end the program.
TEST(KindOf, TooManyElementsInsideEachOtherAreRefused) {
  const TempFolder folder;
  std::string begin, end;
  for (int i = 0; i < 100000; ++i) {
    begin += "<body>";
    end += "</body>";
  }
  const auto file =
      folder.Write("deep.xml", "<mujoco><worldbody>" + begin + end + "</worldbody></mujoco>");
  EXPECT_THAT(testing_support::ErrorOf([&] { KindOf(file); }),
              HasSubstr("deep.xml:1: more than 500 elements are inside each other"));
}

TEST_F(OwnCell, AnArmAndAHandAreCheckedAlone) {
  Write();
  const auto of_arm = CheckModel(folder_ / "arm.xml", Kind::kArm);
  ASSERT_EQ(of_arm.size(), 1u) << TextOfAll(of_arm);
  EXPECT_FALSE(of_arm[0].error);
  EXPECT_THAT(base::TextOf(of_arm[0]), HasSubstr("numeric \"home\": is missing"));
  EXPECT_TRUE(CheckModel(folder_ / "hand.xml", Kind::kHand).empty());
}

// Names.

TEST_F(OwnCell, NamesTheMissingSiteAndTheFile) {
  bench_ = Replaced(bench_, "name=\"workspace\"", "name=\"work_space\"");
  ExpectOne({"scene.xml: error", "site \"workspace\"", "missing", "type=\"cylinder\""});
}
TEST_F(OwnCell, NamesTheMissingCameraAsAWarning) {
  bench_ = Replaced(bench_, "<camera name=\"overview\"", "<camera name=\"over\"");
  ExpectOne({"camera \"overview\"", "missing"}, false);
}
TEST_F(OwnCell, PrintsTheMissingTupleReadyToPaste) {
  arm_ = std::regex_replace(arm_, std::regex("<tuple name=\"arm_joints\">[^]*?</tuple>"), "");
  ExpectOne({"arm.xml: error", "tuple \"arm_joints\"",
             "<element objtype=\"joint\" objname=\"joint7\"/>"});
}
TEST_F(OwnCell, NamesServosWithoutNamesAndListsThem) {
  arm_ = std::regex_replace(arm_, std::regex("<position name=\"[^\"]*\""), "<position");
  for (const bool is_listed : {true, false}) {
    if (!is_listed) {
      const std::regex tuple("<tuple name=\"arm_actuators\">[^]*?</tuple>");
      arm_ = std::regex_replace(arm_, tuple, "");
    }
    const auto findings = Check();
    ASSERT_EQ(findings.size(), 1u) << TextOfAll(findings);
    const std::string text = base::TextOf(findings[0]);
    EXPECT_THAT(text, HasSubstr("name=\"servo_joint7\" in <position joint=\"joint7\">"));
    EXPECT_THAT(text, HasSubstr("<element objtype=\"actuator\" objname=\"servo_joint7\"/>"));
    ASSERT_EQ(findings[0].edits.size(), 8u);
    EXPECT_EQ(findings[0].edits.back().replace, is_listed);
  }
}
// Both fixes give it the same name.
TEST_F(OwnCell, NamesAServoWithoutANameByItsJoint) {
  arm_ = Replaced(arm_, "<position name=\"drive4\" joint", "<motor joint");
  const std::string text = TextOfAll(Check());
  EXPECT_THAT(text, HasSubstr("name=\"servo_joint4\" in <motor joint=\"joint4\">"));
  EXPECT_THAT(text, HasSubstr("arm.xml:66: error: unnamed actuator of joint \"arm/joint4\": is not "
                              "a position servo"));
  EXPECT_THAT(text, HasSubstr("instead of <motor joint=\"joint4\">: <position "
                              "name=\"servo_joint4\" joint=\"joint4\""));
}
// The engine refuses it where the arm is not attached.
TEST_F(OwnCell, SaysWhatToListInATupleOfNoElements) {
  arm_ = std::regex_replace(arm_, std::regex("<position name=\"[^\"]*\""), "<position");
  Write();
  const auto findings = CheckModel(folder_ / "arm.xml", Kind::kArm);
  ASSERT_EQ(findings.size(), 1u) << TextOfAll(findings);
  EXPECT_THAT(base::TextOf(findings[0]), HasSubstr("unrecognized object 'drive1' in tuple"));
  EXPECT_THAT(base::CureOf(findings[0]), HasSubstr("or remove the tuple"));
}
TEST_F(OwnCell, SaysThatATupleHoldsSomethingElse) {
  arm_ = Replaced(arm_, "objtype=\"actuator\" objname=\"drive3\"",
                  "objtype=\"body\" objname=\"link3\"");
  ExpectOne({"tuple \"arm_actuators\"", "must have only elements of type actuator"});
}
TEST_F(OwnCell, SaysThatANumericIsTooShort) {
  arm_ = Replaced(arm_, "data=\"2 2 2 2 2.5 2.5 2.5\"", "data=\"2 2 2\"");
  ExpectOne({"numeric \"joint_velocity\"", "7 numbers above 0, it has 3"});
}
TEST_F(OwnCell, SaysThatTheHandIsMissingAndHowToAttachIt) {
  arm_ = Replaced(arm_, "<attach model=\"hand\" body=\"hand\" prefix=\"hand/\"/>", "");
  ExpectOne({"body \"hand\"", "missing", "<attach model=\"hand\""});
}
TEST_F(OwnCell, SaysThatANameIsThereTwice) {
  scene_ =
      Replaced(scene_, "<body name=\"mount\"", "<site name=\"my/delivery\"/> <body name=\"mount\"");
  ExpectOne({"site \"delivery\"", "exists twice"});
}

// The arm.

TEST_F(OwnCell, SaysThatAJointIsNotListed) {
  arm_ = Replaced(arm_, "<element objtype=\"joint\" objname=\"joint3\"/>", "");
  arm_ = Replaced(arm_, "<element objtype=\"actuator\" objname=\"drive3\"/>", "");
  arm_ = Replaced(arm_, "2 2 2 2 2.5 2.5 2.5", "2 2 2 2.5 2.5 2.5");
  arm_ = Replaced(arm_, "3 3 3 3 5 5 5", "3 3 3 5 5 5");
  SetHome("0 0 -1.67 0 0.5 0");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("is between the world and the hand, but not in"));
}
TEST_F(OwnCell, SaysThatTheActuatorsAreInAnotherOrder) {
  arm_ = Replaced(arm_, "objname=\"drive2\"", "objname=\"drive_x\"");
  arm_ = Replaced(arm_, "objname=\"drive3\"", "objname=\"drive2\"");
  arm_ = Replaced(arm_, "objname=\"drive_x\"", "objname=\"drive3\"");
  const auto findings = Check();
  EXPECT_EQ(findings.size(), 2u) << TextOfAll(findings);
  EXPECT_THAT(TextOfAll(findings),
              HasSubstr("actuator \"arm/drive3\": does not drive joint \"arm/joint2\""));
}
TEST_F(OwnCell, SaysThatADriveIsNoPositionServo) {
  arm_ = Replaced(arm_, "<position name=\"drive4\" joint=\"joint4\" forcerange=\"-87 87\"/>",
                  "<motor name=\"drive4\" joint=\"joint4\"/>");
  ExpectOne({"arm.xml:", "actuator \"arm/drive4\"", "not a position servo",
             "instead of <motor name=\"drive4\">: <position name=\"drive4\" joint=\"joint4\""});
}
TEST_F(OwnCell, SaysThatACommandIsCut) {
  arm_ = Replaced(arm_, "joint=\"joint2\"", "joint=\"joint2\" ctrlrange=\"-1 1\"");
  ExpectOne({"actuator \"arm/drive2\"", "commands from -1 to 1 only"});
}
TEST_F(OwnCell, SaysThatHomeIsOutOfRange) {
  SetHome("-0.32 0.14 -0.45 0 -0.1 0.51 0.09");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("outside the joints' ranges [rad]: arm/joint4 is 0"));
}
TEST_F(OwnCell, SaysThatThereIsNoArmature) {
  arm_ = Replaced(arm_, " armature=\"0.1\"", "");
  ExpectOne(
      {"too little armature", "armature=\"0.1\" in <joint name=\"joint1\">, <joint", "arm.xml:21"});
}
TEST_F(OwnCell, SaysThatGravityIsNotCompensated) {
  arm_ = Replaced(arm_, "<numeric name=\"gravity_compensation\" data=\"1\"/>", "");
  ExpectOne({"not compensated for gravity", "<numeric name=\"gravity_compensation\" data=\"1\"/>",
             "arm/link1"});
}
TEST_F(OwnCell, SaysThatADriveIsTooWeak) {
  arm_ = Replaced(arm_, "joint=\"joint2\" forcerange=\"-150 150\"",
                  "joint=\"joint2\" forcerange=\"-20 20\"");
  ExpectOne({"actuator \"arm/drive2\"", "gives 20 Nm", "forcerange="});
}
TEST_F(OwnCell, SaysThatADriveFallsBehind) {
  arm_ = Replaced(arm_, "<position name=\"drive1\" joint=\"joint1\"",
                  "<position name=\"drive1\" joint=\"joint1\" kp=\"400\"");
  ExpectOne({"actuators arm/drive1: lag", "mrad behind", "in <numeric name=\"joint_acceleration\">",
             "kp "});
}
TEST_F(OwnCell, SaysThatTheHomePoseIsNotHeld) {
  // Gravity is compensated on the last link alone: by a spring that pulls, here, it is not.
  arm_ = Replaced(arm_, "<joint name=\"joint2\"",
                  "<joint name=\"joint2\" stiffness=\"300\" springref=\"0\"");
  ExpectOne({"does not hold the arm at home", "joint \"arm/joint2\"", "kp="});
}

// Bodies.

TEST_F(OwnCell, SaysThatAMassIsOutOfAllProportion) {
  arm_ = Replaced(arm_, "density=\"1500\"", "density=\"1500000\"");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("the arm: has an implausible mass of"));
}
TEST_F(OwnCell, SaysThatAnInertiaIsOutOfAllProportion) {
  arm_ =
      Replaced(arm_, "<joint name=\"joint4\"",
               "<inertial pos=\"0 0 0\" mass=\"2\" diaginertia=\"9 9 9\"/><joint name=\"joint4\"");
  ExpectOne({"body \"arm/link4\"", "has the inertia of 2 kg at", "diaginertia="});
}
TEST_F(OwnCell, SaysThatAMeshIsInMillimetres) {
  base::WriteFile(folder_ / "part.obj",
                  "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  arm_ = Replaced(arm_, "<asset>", "<asset> <mesh name=\"part\" file=\"part.obj\"/>");
  arm_ = Replaced(arm_, "<joint name=\"joint3\"",
                  "<geom class=\"seen\" type=\"mesh\" mesh=\"part\"/> <joint name=\"joint3\"");
  const std::string text = TextOfAll(Check());
  for (const char* what :
       {"mesh \"arm/part\": reaches", "millimetres?", "scale=\"0.001 0.001 0.001\""}) {
    EXPECT_THAT(text, HasSubstr(what));
  }
}
TEST_F(OwnCell, SaysThatALinkDoesNotCollide) {
  arm_ = Replaced(arm_, "<geom fromto=\"0 0 0.02 0 0 0.12\" size=\"0.06\"/>", "");
  arm_ = Replaced(arm_, "<joint name=\"joint2\"",
                  "<inertial pos=\"0 0 0.1\" mass=\"3\" diaginertia=\"0.02 0.02 0.02\"/><joint "
                  "name=\"joint2\"");
  ExpectOne({"bodies arm/link2", "have no collision geoms"}, false);
}
TEST_F(OwnCell, SaysThatNothingIsSeenAndNothingCollides) {
  arm_ = Replaced(arm_, "<geom group=\"2\" contype", "<geom group=\"4\" contype");
  hand_ = Replaced(hand_, "<geom group=\"2\" contype", "<geom group=\"4\" contype");
  ExpectOne({"the arm: has no visible geom", "group=\"2\""});
  arm_ = Replaced(arm_, "group=\"4\" contype", "group=\"2\" contype");
  arm_ =
      Replaced(arm_, "group=\"3\" density", "group=\"3\" contype=\"0\" conaffinity=\"0\" density");
  hand_ = Replaced(hand_, "<geom group=\"3\" type=\"capsule\"",
                   "<geom group=\"3\" contype=\"0\" conaffinity=\"0\" type=\"capsule\"");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("the arm: has no collision geom"));
}

// Contacts.

TEST_F(OwnCell, NamesAPairThatAlwaysTouches) {
  arm_ = Replaced(arm_, "<geom fromto=\"0 0 -0.06 0.08 0 0\" size=\"0.055\"/>",
                  "<geom fromto=\"0 0 -0.3 0.08 0 0\" size=\"0.055\"/>");
  ExpectOne({"bodies \"arm/link1\" and \"arm/link3\"", "touch",
             "<exclude body1=\"arm/link1\" body2=\"arm/link3\"/>"});
  scene_ =
      Replaced(scene_, "</worldbody>",
               "</worldbody><contact><exclude body1=\"arm/link1\" body2=\"arm/link3\"/></contact>");
  EXPECT_TRUE(Check().empty()) << "the cure as printed";
}
TEST_F(OwnCell, NamesWhatTouchesAtHome) {
  scene_ = Replaced(scene_, "<body name=\"mount\"",
                    "<geom name=\"post\" type=\"box\" pos=\"-0.45 0 0.55\" size=\"0.02 0.2 0.01\" "
                    "group=\"3\"/> <body name=\"mount\"");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("overlap by"));
}

// The arm's first links are below the table's top, which is an infinite plane for the engine.
TEST_F(OwnCell, AnArmOnTheFloorIsToldWhatToExcludeFromTheTable) {
  scene_ = base::ReadFile(kArms / "seven_on_floor.xml");
  scene_ = Replaced(scene_, "../../../scenes/bench.xml", "bench.xml");
  scene_ = Replaced(scene_, "seven_joints.xml", "arm.xml");
  const std::string exclude = "<exclude body1=\"table\" body2=\"arm/link2\"/>";
  scene_ = Replaced(scene_, exclude, "");
  ExpectOne({"bodies \"table\" and \"arm/link2\"", "touch", exclude});
}

// The cell.

TEST_F(OwnCell, SaysThatTheEnginesOptionsLetThingsSlip) {
  bench_ = Replaced(bench_, "cone=\"elliptic\"", "cone=\"pyramidal\"");
  ExpectOne({"scene.xml", "pyramidal friction cones", "cone=\"elliptic\""});
}
TEST_F(OwnCell, SaysThatTheTableIsElsewhere) {
  bench_ = Replaced(bench_, "pos=\"0.13 0 0\"/>", "pos=\"0.13 0 -0.05\"/>");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("no table below it has its top at z = 0"));
}
TEST_F(OwnCell, SaysThatTheArmAtHomeStandsInTheView) {
  SetHome("0 0.3 0 -1.6 0 1.3 0");
  EXPECT_THAT(TextOfAll(Check()), HasSubstr("numeric \"home\": body \"arm/"));
}
TEST_F(OwnCell, SaysThatTheWorkspaceIsOutOfReach) {
  scene_ = Replaced(scene_, "pos=\"-0.45 0 0\"", "pos=\"-1.6 0 0\"");
  EXPECT_THAT(TextOfAll(Check()),
              HasSubstr("does not move the hand from above to the workspace's middle"));
}

// The hand.

TEST_F(OwnCell, SaysThatAFingertipIsNotMoved) {
  hand_ = Replaced(hand_, "<element objtype=\"geom\" objname=\"index_3\"/>",
                   "<element objtype=\"geom\" objname=\"index_3\"/><element objtype=\"geom\" "
                   "objname=\"palm\"/>");
  ExpectOne({"hand.xml:", "geom \"arm/hand/palm\"", "fingertip on body \"arm/hand/hand\"",
             "no joint of \"hand_joints\" moves"});
}

TEST_F(OwnCell, PutsWhatTheEngineSaysIntoAFinding) {
  arm_ = Replaced(arm_, "<joint name=\"joint5\"", "<joint name=\"joint5\" type=\"hing\"");
  const auto findings = Check();
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_THAT(base::TextOf(findings[0]), HasSubstr("hing"));
  // The location is a line of the file that the scene attaches.
  EXPECT_TRUE(std::regex_search(findings[0].where, std::regex("arm\\.xml:[0-9]+$")))
      << findings[0].where;
}

TEST_F(OwnCell, NamesTheLineOfWhatIsNoXml) {
  scene_ = Replaced(scene_, "</mujoco>", "</mujoc>");
  const auto findings = Check();
  ASSERT_EQ(findings.size(), 1u);
  const auto lines = std::count(scene_.begin(), scene_.end(), '\n');
  EXPECT_THAT(
      base::TextOf(findings[0]),
      testing::AllOf(HasSubstr("scene.xml:" + std::to_string(lines) + ":"), HasSubstr("XML")));
}

// A typical third-party arm, fixed by following the check's findings.
TEST(ForeignArm, IsToldAllThatItLacksAtOnce) {
  const auto file = labelled::SharedFolder() / "data/robots/kuka_iiwa_14/iiwa14.xml";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  ASSERT_EQ(KindOf(file), Kind::kArm);
  const std::string text = TextOfAll(CheckModel(file, Kind::kArm));
  for (const char* what :
       {"tuple \"arm_joints\": is missing", "objname=\"joint7\"", "tuple \"arm_actuators\"",
        "objname=\"actuator7\"", "numeric \"joint_velocity\"", "numeric \"joint_acceleration\"",
        "numeric \"home\"", "body \"hand\": is missing",
        "armature=\"0.1\" in <joint name=\"joint1\">", "not compensated for gravity"}) {
    EXPECT_THAT(text, HasSubstr(what));
  }
}

// Objects: each fault is reported with its cure.

const std::string kSurface = "<custom><text name='surface' data='plastic'/></custom>";
const std::string kSeen =
    "<geom type='box' size='0.02 0.03 0.05' contype='0' conaffinity='0' group='2' mass='0'/>";
const std::string kSolid = "<geom type='box' size='0.02 0.03 0.05' group='3' mass='0.2'/>";

class CheckObjectTest : public testing::Test {
 protected:
  std::vector<base::Finding> Check(const std::string& body, const std::string& head = kSurface) {
    const auto file = folder_.Write("odd/odd.xml", "<mujoco>" + head +
                                                       "<worldbody><body name='odd'><freejoint/>" +
                                                       body + "</body></worldbody></mujoco>");
    return CheckObject({"odd", file});
  }
  void ExpectOne(bool error, const std::string& what, const std::vector<base::Finding>& findings) {
    ASSERT_EQ(findings.size(), 1U) << what;
    EXPECT_EQ(findings[0].error, error);
    EXPECT_THAT(findings[0].where, HasSubstr("odd.xml"));
    EXPECT_THAT(findings[0].what, HasSubstr(what));
    EXPECT_NE(findings[0].cure, "");
  }
  TempFolder folder_;
};

TEST_F(CheckObjectTest, ShippedObjectsAreSound) {
  for (const auto& entry :
       std::filesystem::directory_iterator(RANGEGRASP_SOURCE_DIR "/models/objects")) {
    const std::string name = entry.path().filename().string();
    for (const auto& finding : CheckObject({name, entry.path() / (name + ".xml")})) {
      ADD_FAILURE() << base::TextOf(finding);
    }
  }
  EXPECT_THAT(Check(kSeen + kSolid), IsEmpty());
}

TEST_F(CheckObjectTest, SizesAndWhatIsSeen) {
  ExpectOne(true, "millimetres", Check("<geom type='box' size='20 30 50' mass='0.2'/>"));
  ExpectOne(true, "too small", Check("<geom type='box' size='2e-5 3e-5 5e-5' mass='0.2'/>"));
  ExpectOne(true, "no visible geom", Check(kSolid));
  ExpectOne(true, "the visible geometry is 50 mm long, the collision geometry 100 mm",
            Check("<geom type='box' size='0.01 0.015 0.025' contype='0' conaffinity='0' group='2' "
                  "mass='0'/>" +
                  kSolid));
}

TEST_F(CheckObjectTest, NothingThatCollidesAndWhatIsNoObject) {
  ExpectOne(true, "at least one collision geom", Check(kSeen));
  const auto file = folder_.Write("odd/odd.xml", "<mujoco><worldbody/></mujoco>");
  ExpectOne(true, "one root body", CheckObject({"odd", file}));
  EXPECT_FALSE(IsObjectFile(file));
  EXPECT_FALSE(IsObjectFile(RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml"));
  EXPECT_TRUE(IsObjectFile(RANGEGRASP_SOURCE_DIR "/models/objects/spread/spread.xml"));
}

// The volume is 0.24 l: 5 g is 21 kg/m3 and 2.9 kg is 12,083 kg/m3.
TEST_F(CheckObjectTest, MassAndInertia) {
  const auto body = [](const std::string& inertial) {
    return inertial + kSeen + "<geom type='box' size='0.02 0.03 0.05' group='3'/>";
  };
  const auto inertial = [](double mass, double moment, double z = 0.0) {
    return fmt::format("<inertial pos='0 0 {}' mass='{}' diaginertia='{} {} {}'/>", z, mass, moment,
                       moment, moment);
  };
  EXPECT_THAT(Check(body(inertial(0.2, 2e-4))), IsEmpty());
  ExpectOne(true, "its mass of 2.9 kg", Check(body(inertial(2.9, 2e-3))));
  ExpectOne(true, "its mass of 0.004 kg", Check(body(inertial(0.004, 4e-6))));
  ExpectOne(true, "its inertia", Check(body(inertial(0.2, 2e-2))));
  ExpectOne(true, "its inertia", Check(body(inertial(0.2, 2e-6))));
  ExpectOne(true, "center of mass", Check(body(inertial(0.2, 2e-4, 0.051))));
}

TEST_F(CheckObjectTest, WhatStandsNowhereAndWhatNamesNoSurface) {
  // A box of 40 x 60 x 100 mm is most stable on its largest side: it tips over at atan(60 / 40).
  ASSERT_THAT(Check(kSeen + kSolid), IsEmpty());
  ExpectOne(true, "no stable resting pose",
            CheckObject({"odd", folder_ / "odd/odd.xml"}, /*min_tipping_rad=*/1.0));
  const auto none = Check(kSeen + kSolid, "");
  ExpectOne(false, "has no surface: friction and reflection of cardboard", none);
  EXPECT_THAT(none[0].cure, HasSubstr("data=\"cardboard\""));
  const auto unknown =
      Check(kSeen + kSolid, "<custom><text name='surface' data='velvet'/></custom>");
  ExpectOne(true, "known surfaces: cardboard", unknown);
  EXPECT_THAT(unknown[0].cure, HasSubstr("named above"));
}

// One mesh contains two separate boxes: its hull is solid, the mesh is not.
TEST_F(CheckObjectTest, AMeshThatIsNotConvexIsSaid) {
  std::string text;
  for (const double x : {-0.04, 0.04}) {
    for (int corner = 0; corner < 8; ++corner) {
      text += fmt::format("v {} {} {}\n", x + ((corner & 1) ? 0.01 : -0.01),
                          (corner & 2) ? 0.02 : -0.02, (corner & 4) ? 0.02 : -0.02);
    }
  }
  for (const int first : {1, 9}) {
    const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (const auto& f : faces) {
      text += fmt::format("f {} {} {}\n", first + f[0], first + f[1], first + f[2]);
    }
  }
  folder_.Write("odd/two.obj", text);
  ExpectOne(false, "is not convex",
            Check("<geom type='mesh' mesh='two' contype='0' conaffinity='0' group='2' mass='0'/>"
                  "<geom type='mesh' mesh='two' group='3' mass='0.05'/>",
                  kSurface + "<asset><mesh name='two' file='two.obj'/></asset>"));
}

}  // namespace
}  // namespace rangegrasp::check
