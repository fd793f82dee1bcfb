// Tests the output and exit codes of `check`, and that `run` refuses what cannot work.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "cli/own_cell.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::kSource;
using testing_support::OwnCell;
using testing_support::Replaced;
using testing_support::RunProgram;

TEST_F(OwnCell, CheckSaysThatNothingIsWrong) {
  Write();
  for (const char* file : {"scene.xml", "own.yaml"}) {
    const auto ran = Succeeded(RunProgram({"check", folder_ / file, "--quick"}));
    EXPECT_THAT(ran.out, HasSubstr("no errors"));
  }
}

TEST_F(OwnCell, CheckOfASceneRunsTrials) {
  Write();
  const auto ran = Succeeded(RunProgram({"check", folder_ / "scene.xml"}));
  EXPECT_THAT(ran.err, HasSubstr("tries 27 trials"));
  EXPECT_THAT(ran.out, HasSubstr("27 trials tried: 27 detected, 27 delivered"));
}

TEST_F(OwnCell, CheckRunsTrialsAndNamesTheRareFailure) {
  experiment_ += "\ngrasp: {centering: false}\n";  // centred grasps deliver every object
  const auto ran = Succeeded(RunProgram({"check", Write()}));
  EXPECT_THAT(ran.err, HasSubstr("tries 27 trials"));
  EXPECT_THAT(ran.out, HasSubstr("27 trials tried: 27 detected, 25 delivered"));
  EXPECT_THAT(ran.out, HasSubstr("the hand: closes without any pressure"));
  EXPECT_THAT(ran.out, HasSubstr("(2 of 27 trials, not_lifted 2: ball_"));
}

// The scanner looks away from the table.
TEST_F(OwnCell, CheckNamesASensorThatSeesNothingOfTheWorkspace) {
  const std::string site = "<site name=\"scanner\"";
  folder_.Write("bench.xml", Replaced(base::ReadFile(kSource + "/scenes/bench.xml"), site,
                                      site + " xyaxes=\"1 0 0 0 -1 0\""));
  scene_ = Replaced(scene_, kSource + "/scenes/bench.xml", "bench.xml");
  const std::string experiment = Write();
  for (const std::string& file : {(folder_ / "scene.xml").string(), experiment}) {
    const auto ran = RunProgram({"check", "--quick", file});
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.out, HasSubstr("the sensor: measures no point of the workspace"));
    EXPECT_THAT(ran.out, HasSubstr("the site \"scanner\" of the scene"));
  }
}

TEST_F(OwnCell, CheckPrintsFindingsWithTheirCureAndEndsWithTwo) {
  BreakArmature();
  const std::string experiment = Write();
  for (const std::string& file : {(folder_ / "scene.xml").string(), experiment}) {
    const auto ran = RunProgram({"check", file});
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.out, HasSubstr("arm.xml:"));
    EXPECT_THAT(ran.out, HasSubstr("error: joints arm/joint1"));
    EXPECT_THAT(ran.out, HasSubstr("fix: armature=\"0.1\""));
    EXPECT_THAT(ran.out, HasSubstr("1 error, 0 warnings"));
  }
  const auto json = RunProgram({"check", folder_ / "scene.xml", "--json"});
  const auto findings = nlohmann::json::parse(json.out).at("findings");
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].at("severity"), "error");
  EXPECT_THAT(std::string(findings[0].at("cure")), HasSubstr("armature"));
}

TEST_F(OwnCell, FixWritesCopiesOfWhatItEditsAndChecksThem) {
  BreakArmature();
  Write();
  const auto ran = Succeeded(RunProgram({"check", "--fix", folder_ / "scene.xml", "--quick"}));
  EXPECT_THAT(ran.out,
              HasSubstr("arm.fixed.xml:21:\n    - <joint name=\"joint1\" axis=\"0 0 1\"/>\n"
                        "    + <joint name=\"joint1\" axis=\"0 0 1\" armature=\"0.1\"/>"));
  EXPECT_THAT(ran.out, HasSubstr("scene.fixed.xml, checked as a scene: no errors"));
  EXPECT_THAT(ran.out, HasSubstr("edits made: 8"));  // seven joints and the scene's reference
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml"), arm_);
  EXPECT_EQ(base::ReadFile(folder_ / "scene.fixed.xml"),
            Replaced(scene_, "arm.xml", "arm.fixed.xml"));
  const std::vector<std::string> words = {"check", "--fix", folder_ / "scene.xml", "--quick",
                                          "--json"};
  const auto again = RunProgram(words);  // edits in a copy are not lost
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("arm.fixed.xml: already exists"));
  std::filesystem::remove(folder_ / "arm.fixed.xml");
  std::filesystem::remove(folder_ / "scene.fixed.xml");
  const auto json = RunProgram(words);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("edits").size(), 8u);
}

TEST_F(OwnCell, FixInPlaceKeepsABackupOfEachTime) {
  BreakArmature();
  Write();
  const std::vector<std::string> words = {"check", "--fix=in-place", folder_ / "scene.xml",
                                          "--quick"};
  EXPECT_EQ(RunProgram(words).code, 0);
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml.bak"), arm_);
  EXPECT_EQ(base::ReadFile(folder_ / "scene.xml"), scene_);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene.xml.bak"));
  const std::string fixed = base::ReadFile(folder_ / "arm.xml");
  arm_ += "<!-- another time -->\n";
  Write();
  EXPECT_EQ(RunProgram(words).code, 0);
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml.bak2"), arm_);
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml.bak") + "<!-- another time -->\n", arm_);
  EXPECT_EQ(base::ReadFile(folder_ / "arm.xml"), fixed + "<!-- another time -->\n");
}

TEST_F(OwnCell, FixMakesNoCopyOfWhatIsRightAndTakesOnlyMjcf) {
  const std::string experiment = Write();
  const std::string scene = folder_ / "scene.xml";
  EXPECT_EQ(RunProgram({"check", "--fix", scene, "--quick"}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene.fixed.xml"));
  EXPECT_THAT(RunProgram({"check", "--fix", experiment}).err, HasSubstr("--fix needs an MJCF"));
  EXPECT_EQ(RunProgram({"check", "--fix=there", scene}).code, 2);
}

TEST_F(OwnCell, CheckTakesAFileForWhatItIsTold) {
  Write();
  const auto ran = RunProgram({"check", folder_ / "arm.xml", "--as", "scene"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.out, HasSubstr("site \"workspace\": is missing"));
  EXPECT_EQ(RunProgram({"check", "no_such_file.xml"}).code, 2);
}

TEST_F(OwnCell, ARunThatCannotWorkIsRefusedWithAllFindings) {
  BreakArmature();
  arm_ = Replaced(arm_, "<numeric name=\"gravity_compensation\" data=\"1\"/>", "");
  const auto ran = Run();
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("has errors"));
  EXPECT_THAT(ran.err, HasSubstr("armature"));
  EXPECT_THAT(ran.err, HasSubstr("gravity_compensation"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

// The sphere of 0.4 m has a thousandth of the mass of its volume of water.
TEST_F(OwnCell, ARunLooksAtItsObjectsToo) {
  folder_.Write("objects/ball/ball.xml",
                "<mujoco><worldbody><body name=\"ball\"><freejoint/><geom size=\".2\" "
                "mass=\"0.03\"/></body></worldbody></mujoco>");
  experiment_ += "object_folders: [objects]\n";
  experiment_ = Replaced(experiment_, "salt_cylinder", "ball");
  const auto ran = Run();
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("ball.xml"));
  EXPECT_THAT(ran.err, HasSubstr("fix: "));
}

TEST_F(OwnCell, CheckOfAnObjectReadsItsKnownGrasps) {
  const auto file = folder_.Write(
      "can/can.xml",
      "<mujoco><worldbody><body name=\"can\"><freejoint/><geom type=\"cylinder\" size=\".03 .05\" "
      "mass=\"0.3\"/></body></worldbody></mujoco>");
  EXPECT_EQ(RunProgram({"check", file}).code, 0);
  folder_.Write("can/grasps.yaml", "grasps:\n  side:\n    at_mm: [0, 0, 0]\n    width: 60\n");
  const auto ran = RunProgram({"check", file});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.out, testing::AllOf(HasSubstr("grasps.yaml:4"), HasSubstr("'width_mm'")));
}

TEST_F(OwnCell, CheckOfAnObjectNamesAKnownGraspOutsideIt) {
  const auto file = folder_.Write(
      "bar/bar.xml",
      "<mujoco><worldbody><body name=\"bar\" pos=\"1 2 3\"><freejoint/><geom type=\"box\" "
      "size=\".02 .03 .05\" mass=\"0.1\"/></body></worldbody></mujoco>");
  const auto grasp = [](const std::string& name, const std::string& at_mm) {
    return "  " + name + ":\n    at_mm: " + at_mm +
           "\n    approach: [0, 0, -1]\n    closing: [1, 0, 0]\n    width_mm: 40\n";
  };
  folder_.Write("bar/grasps.yaml",
                "grasps:\n" + grasp("rim", "[0, 0, 60]") + grasp("neck", "[0, 0, 850]"));
  const auto ran = Succeeded(RunProgram({"check", file}));
  EXPECT_THAT(ran.out, HasSubstr("grasp 'neck': its center (0, 0, 850) mm is outside the model, "
                                 "which reaches from (-20, -30, -50) to (20, 30, 50) mm"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("'rim'"))) << "10 mm above it";
}

TEST_F(OwnCell, CheckOfAnObjectNamesAKnownGraspWiderThanIt) {
  const auto file =
      folder_.Write("slab/slab.xml",
                    "<mujoco><worldbody><body name=\"slab\"><freejoint/><geom type=\"box\" "
                    "size=\".02 .10 .03\" mass=\"0.2\"/></body></worldbody></mujoco>");
  const auto grasp = [](const std::string& name, const std::string& closing, int width_mm) {
    return "  " + name +
           ":\n    at_mm: [0, 0, 20]\n    approach: [0, 0, -1]\n    closing: " + closing +
           "\n    width_mm: " + std::to_string(width_mm) + "\n";
  };
  folder_.Write("slab/grasps.yaml", "grasps:\n" + grasp("across", "[1, 0, 0]", 40) +
                                        grasp("wide", "[1, 0, 0]", 50) +
                                        grasp("along", "[0, 1, 0]", 200));
  const auto ran = Succeeded(RunProgram({"check", file}));
  EXPECT_THAT(ran.out, HasSubstr("grasp 'wide': its width_mm is 50, but the whole model is only "
                                 "40 mm wide along `closing`"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("'across'")));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("'along'")));
}

// The hand that this arm attaches has other options than the arm, which the engine would print and
// log.
TEST_F(OwnCell, TheEngineLeavesNoLogFile) {
  Write();
  const std::filesystem::path log = "MUJOCO_LOG.TXT";
  std::filesystem::remove(log);
  EXPECT_EQ(RunProgram({"check", folder_ / "scene.xml", "--quick"}).err, "");
  EXPECT_FALSE(std::filesystem::exists(log));
}

}  // namespace
}  // namespace rangegrasp
