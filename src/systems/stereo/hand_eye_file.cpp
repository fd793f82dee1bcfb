#include <fmt/format.h>

#include "base/file.h"
#include "base/yaml_map.h"
#include "sensing/hand_eye.h"
#include "stereo/hand_eye.h"
#include "stereo/internal/camera_file.h"

namespace rangegrasp::stereo {
namespace {

std::string ViewName(std::size_t number) { return fmt::format("view_{:02}", number); }

}  // namespace

HandEyeRecord ReadHandEyeRecord(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  HandEyeRecord record;
  map.Require("camera");
  auto camera = map.Child("camera", "its lens, with the distortion of equations 5.10 to 5.12");
  internal::ReadCamera(camera, record.camera);
  if (map.Has("in_head")) {
    record.X_SC = sensing::ReadPoseOf(map, "in_head", "of the camera in the head's frame");
  }
  while (map.Has(ViewName(record.X_WH.size() + 1))) {
    record.X_WH.push_back(
        sensing::ReadPoseOf(map, ViewName(record.X_WH.size() + 1),
                            "of the hand in the arm's frame when the picture was taken"));
  }
  map.Finish();
  return record;
}

void WriteHandEyeRecord(const HandEyeRecord& record, const std::filesystem::path& file) {
  std::string text =
      "# The lens, where the camera is in its head, and the hand in the arm's frame at each "
      "picture.\n" +
      internal::CameraText("camera", record.camera) + sensing::PoseText("in_head", record.X_SC);
  for (std::size_t i = 0; i < record.X_WH.size(); ++i) {
    text += sensing::PoseText(ViewName(i + 1), record.X_WH[i]);
  }
  base::WriteFile(file, text);
}

}  // namespace rangegrasp::stereo
