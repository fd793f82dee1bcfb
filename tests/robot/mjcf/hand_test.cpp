#include "robot/mjcf/hand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "robot/mjcf/example_hands.h"
#include "temp_folder.h"

namespace rangegrasp::mjcf {
namespace {

// Interpolates linearly between the points.
double GapAt(const HandClosing& closing, double share) {
  const double at = share * static_cast<double>(closing.points.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), closing.points.size() - 2);
  return std::lerp(closing.points[i].gap_m, closing.points[i + 1].gap_m,
                   at - static_cast<double>(i));
}

using samples::LoadHand;
using ::testing::HasSubstr;

TEST(HandFile, ADriveHasAnOpenAndAClosedEnd) {
  const auto model = LoadHand("parallel_jaw");
  const auto motors = HandMotors(model.get());
  ASSERT_EQ(motors.size(), 1u);
  EXPECT_EQ(motors[0].open, 0.05);
  EXPECT_EQ(motors[0].closed, 0.0);
  EXPECT_TRUE(HasMotors(model.get()));
  EXPECT_FALSE(HasMotors(LoadHand("sensorhand").get()));
}

TEST(EngineMessage, NamesTheFileAndLineThatTheEngineMeans) {
  const testing_support::TempFolder folder;
  const auto main = folder.Write("main.xml", "<mujoco>\n<include file=\"arm.xml\"/>\n</mujoco>\n");
  const auto arm = folder.Write("arm.xml", "<mujoco>\n\n<joint name=\"a\"/>\n</mujoco>\n");
  const std::string message = "XML Error: bad\nElement 'joint', line 3\n";
  EXPECT_EQ(EngineMessage(main, message),
            arm.string() + ":3: XML Error: bad; Element 'joint', line 3");
  EXPECT_EQ(EngineMessage(main, "no memory"), main.string() + ": no memory");
  // If two files are possible, neither is named; if only one is possible, no element is needed.
  folder.Write("main.xml", "<mujoco>\n<include file=\"arm.xml\"/>\n<joint/>\n</mujoco>\n");
  EXPECT_THAT(EngineMessage(main, message),
              HasSubstr("line 3 (in this file, or in one that it includes"));
  EXPECT_EQ(EngineMessage(arm, "tags differ, line 9"), arm.string() + ":9: tags differ, line 9");
  // An attached file is the one that the outer elements lead to.
  const auto cell = folder.Write("cell.xml", "\n\n<joint/><model file=\"main.xml\"/>\n");
  folder.Write("main.xml", "\n\n<joint/>\n<model file='arm.xml'/>\n");
  EXPECT_EQ(EngineMessage(cell,
                          "bad; Element 'joint', line 3; Element 'model', line 4; Element "
                          "'model', line 3"),
            arm.string() +
                ":3: bad; Element 'joint', line 3; Element 'model', line 4; Element "
                "'model', line 3");
  EXPECT_THAT(EngineMessage(cell,
                            "no XML; Line number=3; Element 'model', line 4; Element "
                            "'model', line 3"),
              HasSubstr(arm.string() + ":3: no XML"));
}

TEST(EngineMessage, SaysThatAFileIsNotXmlInPlaceOfTheParsersWords) {
  const testing_support::TempFolder folder;
  const std::string message = "XML parse error 8:\nError=XML_ERROR_PARSING_TEXT Line number=1\n";
  const auto experiment = folder.Write("e.yaml", "# An experiment\nname: e\n");
  EXPECT_THAT(EngineMessage(experiment, message),
              testing::StartsWith(experiment.string() + ": is not XML; an MJCF file"));
  const auto broken = folder.Write("broken.mjcf", "\xef\xbb\xbf\n<mujoco>\n");
  EXPECT_EQ(EngineMessage(broken, message),
            broken.string() + ":1: XML parse error 8:; Error=XML_ERROR_PARSING_TEXT Line number=1");
}

TEST(HandFile, TheFirstFingertipIsTheThumbs) {
  const auto model = LoadHand("three_fingers");
  const LastSegments last = LastSegmentsOf(model.get());
  ASSERT_EQ(last.thumb.size(), 1u);
  ASSERT_EQ(last.fingers.size(), 2u);
  EXPECT_EQ(std::string(mj_id2name(model.get(), mjOBJ_GEOM, last.thumb[0])), "thumb_2");
}

// In the geared hand, whose thumb is on the first of its joints, the segments nearer to the palm
// are not last segments.
TEST(HandFile, LastSegmentsHaveNoFingertipsFurtherOut) {
  const auto model = LoadHand("sensorhand");
  const LastSegments last = LastSegmentsOf(model.get());
  std::vector<std::string> names;
  for (const int g : last.fingers) names.emplace_back(mj_id2name(model.get(), mjOBJ_GEOM, g));
  EXPECT_THAT(names, ::testing::ElementsAre("index_3", "middle_3"));
}

TEST(HandFile, SaysThatAValueIsMissing) {
  auto model = LoadHand("three_fingers");
  const int id = mj_name2id(model.get(), mjOBJ_NUMERIC, "hand_closed");
  model->numeric_size[id] = 2;
  try {
    HandMotors(model.get());
    FAIL();
  } catch (const base::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("\"hand_closed\" must have one value for each of the 3"));
  }
}

// The engine's stored lengths are from its last kinematics call.
TEST(HandFile, ADrivesLengthIsThatOfTheJointsAsTheyAre) {
  const auto model = LoadHand("sensorhand");
  const samples::DataPtr data(mj_makeData(model.get()), mj_deleteData);
  const int thumb = mj_name2id(model.get(), mjOBJ_JOINT, "thumb");
  const int fingers = mj_name2id(model.get(), mjOBJ_JOINT, "fingers");
  data->qpos[model->jnt_qposadr[thumb]] = 0.2;
  data->qpos[model->jnt_qposadr[fingers]] = 0.4;
  EXPECT_DOUBLE_EQ(DriveLength(model.get(), data.get(), 0), 0.3);
}

using samples::ParseHand;

// A closing is linear between its stored points, 1 mm apart. Drives come within a hundredth of such
// a step: 0.05 mm.
constexpr double kTolerance_m = 1e-4;

// The hand is closed at the lower end of its slides. The gap is 100 mm at 0.05 m each and 0 at 0.
TEST(ParallelJaw, TheGapIsWhatItsSlidesLeave) {
  const auto model = LoadHand("parallel_jaw");
  const HandClosing closing = CloseOnNothing(model.get());
  for (double share = 0.0; share <= 0.99; share += 0.09) {
    EXPECT_NEAR(GapAt(closing, share), 0.1 * (1.0 - share), kTolerance_m) << share;
  }
  EXPECT_NEAR(closing.NarrowingAt(0.5), 0.1, 0.001);
  EXPECT_NEAR(closing.ShareAtGap(0.04), 0.6, 0.002);
  EXPECT_LT(closing.behind, 0.01);
  EXPECT_LT(closing.equality_m, 1e-4);
}

// The hand is closed at the upper end of its hinges. First segments are 55 mm long, 35 mm from the
// middle, and lean out by 30 deg. Last segments stay upright, two of them 16 mm to the side. Their
// axes are hypot(2 x, 16 mm) apart, x = 35 + 55 sin(30 deg - q); their surfaces are 18 mm closer.
TEST(ThreeFingers, TheGapFollowsFromTheHingesAndTheirFollowers) {
  const auto model = LoadHand("three_fingers");
  const HandClosing closing = CloseOnNothing(model.get());
  for (double share = 0.0; share < closing.Touching(); share += 0.07) {
    const double x = 0.035 + 0.055 * std::sin(mjPI / 6 - 1.16 * share);
    EXPECT_NEAR(GapAt(closing, share), std::hypot(2 * x, 0.016) - 0.018, 2 * kTolerance_m) << share;
  }
  EXPECT_LT(closing.Touching(), 1.0);
  EXPECT_EQ(GapAt(closing, 0.0), closing.points.front().gap_m);
}

// A drive turns a crank. Only a connect moves the bar next to it and the pad on the bar.
constexpr const char* kLinkage = R"(<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <default><geom type="box" size="0.005 0.01 0.01" mass="0.02"/><joint axis="0 1 0" armature="0.001"/></default>
  <worldbody>
    <body name="hand">
      <geom name="palm" size="0.05 0.02 0.005"/>
      <body name="thumb_crank" pos="0.06 0 0.01"><joint name="thumb_crank" range="-1 1"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.04" size="0.002" contype="0" conaffinity="0"/></body>
      <body name="thumb_bar" pos="0.08 0 0.01"><joint name="thumb_bar"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.04" size="0.002" contype="0" conaffinity="0"/>
        <body name="thumb_pad" pos="0 0 0.04"><joint name="thumb_pad"/>
          <geom name="thumb_pad" pos="-0.01 0 0"/></body></body>
      <body name="finger" pos="-0.06 0 0.05"><joint name="finger" type="slide" axis="1 0 0" range="0 0.1"/>
        <geom name="finger_pad"/></body>
      <site name="tcp" pos="0 0 0.05"/>
    </body>
  </worldbody>
  <equality>
    <connect body1="thumb_crank" body2="thumb_pad" anchor="0 0 0.04" solref="0.005 1" solimp="0.99 0.999 0.001"/>
  </equality>
  <actuator><position name="crank" joint="thumb_crank" kp="10"/></actuator>
  <custom>
    <tuple name="hand_motors"><element objtype="actuator" objname="crank"/></tuple>
    <tuple name="fingertips"><element objtype="geom" objname="thumb_pad"/>
      <element objtype="geom" objname="finger_pad"/></tuple>
    <numeric name="hand_open" data="0.6"/><numeric name="hand_closed" data="-0.6"/>
  </custom>
</mujoco>)";

TEST(Linkage, APadIsCarriedByWhatEqualitiesJoinToTheDrive) {
  const auto model = ParseHand(kLinkage);
  const HandClosing closing = CloseOnNothing(model.get());
  // The connect joins the crank's end to the pad's body, 20 mm from its hinge. The two bars of
  // 40 mm are 20 mm apart and start upright. They form a parallelogram, so the bar turns like the
  // crank.
  const auto bar =
      std::ranges::find(closing.joints, mj_name2id(model.get(), mjOBJ_JOINT, "thumb_bar")) -
      closing.joints.begin();
  for (const auto& point : closing.points) {
    EXPECT_NEAR(point.positions[bar], 0.6 - 1.2 * point.share, 0.02);
  }
  EXPECT_LT(closing.equality_m, 5e-4);
}

// The data sheet of the Robotiq 2F-85 says 85 mm. Four-bar linkages keep its pads parallel.
TEST(Robotiq2F85, OpensAsItsDataSheetSays) {
  const char* shared = std::getenv("RANGEGRASP_SHARED");
  const auto folder = shared
                          ? std::filesystem::path(shared)
                          : std::filesystem::path(RANGEGRASP_SOURCE_DIR).parent_path() / "shared";
  const auto file = folder / "data/robots/robotiq_2f85/2f85.xml";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  char error[500] = "";
  mjSpec* spec = mj_parseXML(file.c_str(), nullptr, error, sizeof error);
  ASSERT_TRUE(spec) << error;
  mjs_setName(mjs_findBody(spec, "base_mount")->element, "hand");
  mjsTuple* tips = mjs_addTuple(spec);
  mjs_setName(tips->element, "fingertips");
  mjsTuple* motors = mjs_addTuple(spec);
  mjs_setName(motors->element, "hand_motors");
  const int geom = mjOBJ_GEOM, actuator = mjOBJ_ACTUATOR;
  const double zeros[2] = {0, 0};
  const int geoms[2] = {geom, geom};
  mjs_setInt(tips->objtype, geoms, 2);
  mjs_appendString(tips->objname, "right_pad1");
  mjs_appendString(tips->objname, "left_pad1");
  mjs_setDouble(tips->objprm, zeros, 2);
  mjs_setInt(motors->objtype, &actuator, 1);
  mjs_appendString(motors->objname, "fingers_actuator");
  mjs_setDouble(motors->objprm, zeros, 1);
  const auto numeric = [&](const char* name, double value) {
    mjsNumeric* n = mjs_addNumeric(spec);
    mjs_setName(n->element, name);
    mjs_setDouble(n->data, &value, 1);
    n->size = 1;
  };
  numeric("hand_open", 0.0);
  numeric("hand_closed", 0.8);
  const auto model = samples::Compiled(spec);
  const HandClosing closing = CloseOnNothing(model.get());
  EXPECT_NEAR(GapAt(closing, 0.0), 0.085, 0.003);
  EXPECT_LT(GapAt(closing, 1.0), 0.002);
  EXPECT_LT(closing.equality_m, 5e-4);
}

TEST(HandClosing, SaysWhichDriveStopsShort) {
  auto model = LoadHand("parallel_jaw");
  const int joint = mj_name2id(model.get(), mjOBJ_JOINT, "thumb_jaw");
  model->jnt_range[2 * joint] = 0.02;
  const HandClosing closing = CloseOnNothing(model.get());
  // The range limit is soft for a servo this stiff: it yields by 2 of 20 mm.
  EXPECT_NEAR(closing.behind, 0.4, 0.05);
  EXPECT_EQ(closing.behind_actuator, mj_name2id(model.get(), mjOBJ_ACTUATOR, "jaw_drive"));
}

std::vector<double> ForcesAt(const mjModel* model, double share) {
  const HandClosing closing = CloseOnNothing(model);
  const samples::DataPtr data(mj_makeData(model), mj_deleteData);
  closing.Pose(model, data.get(), share);
  mj_forward(model, data.get());
  return GripForces(model, data.get(), HandMotors(model), closing, share, Eigen::Vector3d::UnitX());
}

// One drive pulls both jaws, so it needs 2 N for 1 N at each, towards lower positions.
TEST(GripForces, OneDriveOfTwoJawsGivesTwice) {
  const auto model = LoadHand("parallel_jaw");
  const auto forces = ForcesAt(model.get(), 0.5);
  ASSERT_EQ(forces.size(), 1u);
  EXPECT_NEAR(forces[0], -2.0, 0.02);
}

// A last segment that stays upright presses with torque / (55 mm cos(30 deg - q)), wherever the
// contact is; its follower's equality carries the rest. Two fingers share the thumb's force.
TEST(GripForces, FollowersLeaveTheDriveItsFirstSegmentsLever) {
  const auto model = LoadHand("three_fingers");
  for (const double share : {0.1, 0.5, 0.8}) {
    const auto forces = ForcesAt(model.get(), share);
    const double lever_m = 0.055 * std::cos(mjPI / 6 - 1.16 * share);
    ASSERT_EQ(forces.size(), 3u);
    EXPECT_NEAR(forces[0], lever_m, 5e-4) << share;
    EXPECT_NEAR(forces[1], 0.5 * lever_m, 5e-4) << share;
    EXPECT_NEAR(forces[2], 0.5 * lever_m, 5e-4) << share;
  }
}

}  // namespace
}  // namespace rangegrasp::mjcf
