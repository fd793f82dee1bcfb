#pragma once

#include <gtest/gtest.h>

#include "cli/command.h"

namespace rangegrasp::testing_support {

inline const std::string kSource = RANGEGRASP_SOURCE_DIR;
inline const std::string kArms = kSource + "/tests/data/arms/";

inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A separate cell, as a user would have it: an arm, a scene and an experiment.
class OwnCell : public testing::Test {
 protected:
  void SetUp() override {
    arm_ = Replaced(base::ReadFile(kArms + "seven_joints.xml"), "../../../models",
                    kSource + "/models");
    scene_ = Replaced(base::ReadFile(kArms + "seven_on_pedestal.xml"), "../../../scenes",
                      kSource + "/scenes");
    scene_ = Replaced(scene_, "seven_joints.xml", "arm.xml");
    experiment_ = "name: own\nscene: scene.xml\nsensor: " + kSource +
                  "/models/sensors/line_scanner.yaml\nobjects: [salt_cylinder, "
                  "salt_cuboid]\ntrials_per_object: 3\n";
  }
  std::string Write() {
    folder_.Write("arm.xml", arm_);
    folder_.Write("scene.xml", scene_);
    return folder_.Write("own.yaml", experiment_);
  }
  Ran Run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run", Write(), "--jobs", "1", "--out", folder_ / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  void BreakArmature() { arm_ = Replaced(arm_, " armature=\"0.1\"", ""); }

  TempFolder folder_;
  std::string arm_, scene_, experiment_;
};

}  // namespace rangegrasp::testing_support
