#pragma once

#include <filesystem>
#include <string>

#include "base/file.h"
#include "temp_folder.h"

namespace rangegrasp::testing_support {

/// Writes the shipped cell with another hand at the arm's flange, as in docs/bring-your-own.md. The
/// flange's axis is the hand's approach direction z.
/// @return the scene
inline std::filesystem::path WriteHandCell(const TempFolder& folder, const std::string& hand_xml) {
  const std::filesystem::path source = RANGEGRASP_SOURCE_DIR;
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  std::string arm = base::ReadFile(source / "models/arm/lwa3.xml");
  arm = replaced(arm, "../hand/sensorhand.xml", "hand.xml");
  arm = replaced(arm, "<frame xyaxes=\"0 1 0 0 0 1\">", "<frame>");
  arm = replaced(arm, "<frame pos=\"-0.010 0.075 -0.020\">", "<frame>");
  const std::string scene =
      replaced(base::ReadFile(source / "scenes/tabletop.xml"), "../models/arm/lwa3.xml", "arm.xml");
  base::WriteFile(folder / "hand.xml", hand_xml);
  base::WriteFile(folder / "arm.xml", arm);
  base::WriteFile(folder / "scene.xml", scene);
  return folder / "scene.xml";
}

inline std::string ExampleHand(const std::string& name) {
  return base::ReadFile(std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "models/hand" /
                        (name + ".xml"));
}

}  // namespace rangegrasp::testing_support
