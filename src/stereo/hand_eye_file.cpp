#include <fmt/format.h>

#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "core/yaml_map.h"
#include "stereo/hand_eye.h"
#include "stereo/internal/camera_file.h"

namespace rangegrasp::stereo {
namespace {

using core::kDeg;
using core::kMm;

core::Pose PoseOf(core::YamlMap& map, const std::string& key, const std::string& of) {
  map.Require(key);
  core::YamlMap pose = map.Child(key, of);
  return internal::ReadPose(pose, of);
}

std::string ViewName(std::size_t number) { return fmt::format("view_{:02}", number); }

}  // namespace

HandEye ReadHandEye(const std::filesystem::path& file) {
  auto map = core::YamlMap::FromFile(file);
  HandEye hand_eye;
  hand_eye.X_HS = PoseOf(map, "head", "of the sensor's head in the hand's frame");
  map.ReadScaled("error_mm", hand_eye.shift_error_m, kMm, 0.0, 100.0,
                 "standard error of its place, root mean square");
  map.ReadScaled("error_deg", hand_eye.turn_error_rad, kDeg, 0.0, 30.0, "and of its turn");
  map.Finish();
  return hand_eye;
}

void WriteHandEye(const HandEye& hand_eye, const std::filesystem::path& file) {
  core::WriteFile(file,
                  "# Where a sensor's head sits on the hand (axes of the head: x right, y down, z "
                  "forward), and the\n# standard errors of that.\n" +
                      internal::PoseText("head", hand_eye.X_HS) +
                      fmt::format("error_mm: {:.17g}\nerror_deg: {:.17g}\n",
                                  hand_eye.shift_error_m / kMm, hand_eye.turn_error_rad / kDeg));
}

HandEyeRecord ReadHandEyeRecord(const std::filesystem::path& file) {
  auto map = core::YamlMap::FromFile(file);
  HandEyeRecord record;
  map.Require("camera");
  auto camera = map.Child("camera", "its lens, with the distortion of equations 5.10 to 5.12");
  internal::ReadCamera(camera, record.camera);
  if (map.Has("in_head")) {
    record.X_SC = PoseOf(map, "in_head", "of the camera in the head's frame");
  }
  while (map.Has(ViewName(record.X_WH.size() + 1))) {
    record.X_WH.push_back(PoseOf(map, ViewName(record.X_WH.size() + 1),
                                 "of the hand in the arm's frame when the picture was taken"));
  }
  map.Finish();
  return record;
}

void WriteHandEyeRecord(const HandEyeRecord& record, const std::filesystem::path& file) {
  std::string text =
      "# The lens, where the camera is in its head, and the hand in the arm's frame at each "
      "picture.\n" +
      internal::CameraText("camera", record.camera) + internal::PoseText("in_head", record.X_SC);
  for (std::size_t i = 0; i < record.X_WH.size(); ++i) {
    text += internal::PoseText(ViewName(i + 1), record.X_WH[i]);
  }
  core::WriteFile(file, text);
}

}  // namespace rangegrasp::stereo
