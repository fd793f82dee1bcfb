#include "recognition/views/look_options.h"

namespace rangegrasp::views {

namespace {

void ReadLook(base::YamlMap map, LookOptions& options) {
  using base::kDeg;
  using base::kMm;
  constexpr double kCm3 = 1e-6;
  map.ReadPath("sensor", options.sensor,
               "file of the line scanner at the scene's site wrist_scanner");
  map.ReadScaled("mount_sigma_mm", options.mount_sigma_m, kMm, 0.0, 20.0,
                 "how far the head sits elsewhere on the flange than the robot believes, root mean "
                 "square; one draw a trial");
  map.ReadScaled("mount_sigma_deg", options.mount_sigma_rad, kDeg, 0.0, 5.0,
                 "and how it is turned");
  map.ReadPath("hand_eye", options.hand_eye,
               "file of calibrate-hand-eye, in place of the draw: where the head sits");
  for (const char* key : {"mount_sigma_mm", "mount_sigma_deg"}) {
    if (!options.hand_eye.empty() && map.Has(key)) {
      map.Fail(key,
               "look.hand_eye says where the head sits and how well that is known; only one "
               "of both");
    }
  }
  map.Read("refine", options.refine,
           "views are laid onto the earlier ones; off: as the arm says they are");
  map.ReadScaled("region_radius_mm", options.region_radius_m, kMm, 20.0, 500.0,
                 "space about the highest thing that views are chosen for");
  map.ReadScaled("min_gain_cm3", options.next.min_gain_m3, kCm3, 0.0, 1e6,
                 "a view that would see less new space there is not taken");
  map.ReadScaled("cell_mm", options.next.cell_m, kMm, 2.0, 50.0,
                 "of the space that it is counted in");
  map.Finish();
}

}  // namespace

void ReadLookOptions(base::YamlMap& map, LookOptions& options) {
  map.Read(
      "views", options.views, 1, 10,
      "looks of a trial: the first with the sensor, others from the wrist, where they tell most");
  ReadLook(map.Child("look", "looks from the wrist, where there is more than one view"), options);
  if (options.views > 1 && options.sensor.empty()) {
    map.Fail("views",
             "more than one needs look: {sensor: FILE}, the scanner on the wrist "
             "(models/sensors/wrist_scanner.yaml)");
  }
}

}  // namespace rangegrasp::views
