#pragma once

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

namespace rangegrasp::mjcf::samples {

using ModelPtr = std::unique_ptr<mjModel, void (*)(mjModel*)>;
using DataPtr = std::unique_ptr<mjData, void (*)(mjData*)>;

inline ModelPtr Compiled(mjSpec* spec) {
  ModelPtr model(spec ? mj_compile(spec, nullptr) : nullptr, mj_deleteModel);
  EXPECT_TRUE(model);
  mj_deleteSpec(spec);
  return model;
}

inline ModelPtr LoadHand(const std::string& name) {
  const auto file = std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "models/hand" / (name + ".xml");
  char error[500] = "";
  mjSpec* spec = mj_parseXML(file.c_str(), nullptr, error, sizeof error);
  EXPECT_TRUE(spec) << error;
  return Compiled(spec);
}

inline ModelPtr ParseHand(const std::string& xml) {
  char error[500] = "";
  mjSpec* spec = mj_parseXMLString(xml.c_str(), nullptr, error, sizeof error);
  EXPECT_TRUE(spec) << error;
  return Compiled(spec);
}

}  // namespace rangegrasp::mjcf::samples
