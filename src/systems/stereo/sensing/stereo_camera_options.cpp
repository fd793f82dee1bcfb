#include "stereo/sensing/stereo_camera_options.h"

#include <stdexcept>
#include <string>

#include "base/range_check.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;

constexpr char kType[] = "stereo_camera";
constexpr char kPansAreOne[] = "left_pan_deg must be less than right_pan_deg";

template <typename Source, typename Options>
void ReadLens(Source& from, Options& o) {
  from.Read("width_px", o.width, 64, 8192, "columns of a picture");
  from.Read("height_px", o.height, 64, 8192, "rows of a picture");
  from.Read("focal_px", o.focal_px, 50.0, 50000.0, "focal length of the lens");
  from.Read("center_right_px", o.center_right_px, -200.0, 200.0,
            "of the principal point from the picture's middle");
  from.Read("center_down_px", o.center_down_px, -200.0, 200.0, "likewise");
  from.Read("k1", o.k1, -0.5, 0.5, "radial distortion (equation 5.10)");
  from.Read("k2", o.k2, -0.5, 0.5, "radial distortion, of the fourth power");
  from.Read("p1", o.p1, -0.05, 0.05, "tangential distortion");
  from.Read("p2", o.p2, -0.05, 0.05, "tangential distortion");
}

template <typename Source, typename Options>
void ReadMount(Source& from, Options& o) {
  from.ReadScaled("ahead_mm", o.ahead_m, kMm, 1.0, 2000.0,
                  "of the camera before the pan axis, which makes the baseline");
  from.ReadScaled("mount_right_mm", o.mount_right_m, kMm, -100.0, 100.0,
                  "error of the camera's place that only a calibration can tell");
  from.ReadScaled("mount_down_mm", o.mount_down_m, kMm, -100.0, 100.0, "likewise");
  from.ReadScaled("mount_roll_deg", o.mount_roll_rad, kDeg, -10.0, 10.0, "and of its direction");
  from.ReadScaled("mount_pitch_deg", o.mount_pitch_rad, kDeg, -10.0, 10.0, "likewise");
  from.ReadScaled("mount_yaw_deg", o.mount_yaw_rad, kDeg, -10.0, 10.0, "likewise");
  from.ReadScaled("left_pan_deg", o.left_pan_rad, kDeg, -45.0, 45.0, "turn of the left picture");
  from.ReadScaled("right_pan_deg", o.right_pan_rad, kDeg, -45.0, 45.0, "turn of the right one");
  from.ReadScaled("pan_sigma_deg", o.pan_sigma_rad, kDeg, 0.0, 1.0,
                  "standard deviation of both turns, one value a picture");
}

template <typename Source, typename Options>
void ReadPicture(Source& from, Options& o) {
  from.Read("fine_print", o.fine_print, "lists, bar codes and pictures on packages");
  from.Read("edge_samples", o.edge_samples, 0, 16, "of a pixel, for smooth edges");
  from.Read("shadow_px", o.shadow_px, 0, 16384, "edge of the map of shadows, 0 for none");
  from.Read("lens_blur_px", o.lens_blur_px, 0.0, 1.0, "standard deviation of the lens's blur");
  from.Read("vignetting", o.vignetting, 0.0, 0.9, "share of the light missing in the corners");
  from.Read("exposure_sigma", o.exposure_sigma, 0.0, 0.5,
            "standard deviation of a picture's exposure, as a share");
  from.Read("noise_levels", o.noise_levels, 0.0, 50.0,
            "standard deviation of red, green and blue, of 255");
}

template <typename Source, typename Options>
void ReadKeys(Source& from, Options& options) {
  ReadLens(from, options);
  ReadMount(from, options);
  ReadPicture(from, options);
}

bool PansDiffer(const StereoCameraOptions& options) {
  return options.left_pan_rad < options.right_pan_rad;
}

}  // namespace

StereoCameraOptions ReadStereoCamera(base::YamlMap& map) {
  std::string type = kType;
  map.Read("type", type, "the kind of sensor: stereo_camera");
  if (type != kType) map.Fail("type", "'" + type + "' must be " + kType);
  StereoCameraOptions options;
  ReadKeys(map, options);
  map.Finish();
  if (!PansDiffer(options)) {
    map.Fail(map.Has("left_pan_deg") ? "left_pan_deg" : "right_pan_deg", kPansAreOne);
  }
  return options;
}

StereoCameraOptions ReadStereoCamera(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  return ReadStereoCamera(map);
}

void CheckOptions(const StereoCameraOptions& options) {
  const std::string what = "stereo camera";
  const base::RangeCheck check(what);
  ReadKeys(check, options);
  if (!PansDiffer(options)) throw std::invalid_argument(what + ": " + kPansAreOne);
}

}  // namespace rangegrasp::sensing
