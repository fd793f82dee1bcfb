// What `check` prints and how it ends, and that `run` refuses, stops early and tells of crashes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/command.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::string kSource = RANGEGRASP_SOURCE_DIR;
const std::string kArms = kSource + "/tests/data/arms/";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A cell of its own, as a user has it: an arm, a scene, an experiment.
class OwnCell : public testing::Test {
 protected:
  void SetUp() override {
    arm_ = Replaced(core::ReadFile(kArms + "seven_joints.xml"), "../../../models",
                    kSource + "/models");
    scene_ = Replaced(core::ReadFile(kArms + "seven_on_pedestal.xml"), "../../../scenes",
                      kSource + "/scenes");
    scene_ = Replaced(scene_, "seven_joints.xml", "arm.xml");
    experiment_ = "name: own\nscene: scene.xml\nsensor: " + kSource +
                  "/models/sensors/line_scanner.yaml\nobject_folder: " + kSource +
                  "/models/objects\nobjects: [salt_cylinder, salt_cuboid]\ntrials_per_object: 3\n";
  }
  std::string Write() {
    folder_.Write("arm.xml", arm_);
    folder_.Write("scene.xml", scene_);
    return folder_.Write("own.yaml", experiment_).string();
  }
  testing_support::Ran Run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run", Write(), "--jobs",
                                          "1",   "--out", (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  void BreakArmature() { arm_ = Replaced(arm_, " armature=\"0.1\"", ""); }

  TempFolder folder_;
  std::string arm_, scene_, experiment_;
};

TEST_F(OwnCell, CheckSaysThatNothingIsWrong) {
  Write();
  for (const char* file : {"scene.xml", "arm.xml", "own.yaml"}) {
    const auto ran = RunProgram({"check", (folder_ / file).string()});
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("nothing is wrong"));
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
    EXPECT_THAT(ran.out, HasSubstr("cure: armature=\"0.1\""));
    EXPECT_THAT(ran.out, HasSubstr("1 errors, 0 warnings"));
  }
  const auto json = RunProgram({"check", (folder_ / "scene.xml").string(), "--json"});
  const auto findings = nlohmann::json::parse(json.out).at("findings");
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].at("severity"), "error");
  EXPECT_THAT(std::string(findings[0].at("cure")), HasSubstr("armature"));
}

TEST_F(OwnCell, CheckTakesAFileForWhatItIsTold) {
  Write();
  const auto ran = RunProgram({"check", (folder_ / "arm.xml").string(), "--as", "scene"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.out, HasSubstr("site \"workspace\": is missing"));
  EXPECT_EQ(RunProgram({"check", "no_such_file.xml"}).code, 2);
}

TEST_F(OwnCell, ARunThatCannotWorkIsRefusedWithAllFindings) {
  BreakArmature();
  arm_ = Replaced(arm_, "<numeric name=\"gravity_compensation\" data=\"1\"/>", "");
  const auto ran = Run();
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("cannot work"));
  EXPECT_THAT(ran.err, HasSubstr("armature"));
  EXPECT_THAT(ran.err, HasSubstr("gravity_compensation"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(OwnCell, ARunThatFailsAlwaysInTheSameWayStopsAndSaysWhatIsNotRun) {
  // Of a glove without friction everything slips.
  const auto ran = Run({"--set", "stop_after=4", "--set", "physics.glove_friction=0.01"});
  EXPECT_EQ(ran.code, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("stopped after 4 of 6 cases, which all ended in not_lifted"));
  EXPECT_THAT(ran.err, HasSubstr("2 cases were not run"));
  EXPECT_THAT(ran.out, HasSubstr("2 of 6 cases are missing"));
  const auto resumed =
      Run({"--set", "stop_after=4", "--set", "physics.glove_friction=0.01", "--resume"});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, Not(HasSubstr("missing")));
}

TEST_F(OwnCell, ARunThatMayNotStopGoesOn) {
  const auto ran = Run({"--set", "stop_after=0", "--set", "physics.glove_friction=0.01"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, Not(HasSubstr("missing")));
}

}  // namespace
}  // namespace rangegrasp
