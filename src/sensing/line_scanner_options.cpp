#include "sensing/line_scanner_options.h"

#include "base/yaml_map.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;

constexpr double kMicrometer = 1e-6;

/// Every key with its option, range and documentation. The source is a file or a check of ranges.
template <typename Source, typename Options>
void ReadKeys(Source& from, Options& o) {
  from.Read("samples", o.samples, 2, 8192, "number of points of a profile, along the line");
  from.Read("profiles", o.profiles, 1, 8192, "number of profiles of a scan");
  from.ReadScaled("fan_deg", o.fan_rad, kDeg, 0.1, 120.0,
                  "opening angle of the laser's fan, and of the camera along the line");
  from.ReadScaled(
      "pan_range_deg", o.pan_range_rad, kDeg, 0.0, 180.0,
      "angle between the first and the last profile, symmetric about the forward direction");
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0,
                  "distance from the laser to the camera");
  from.ReadScaled("focal_length_mm", o.focal_length_m, kMm, 0.5, 500.0,
                  "focal length of the camera's lens");
  from.ReadScaled("pixel_pitch_um", o.pixel_pitch_m, kMicrometer, 0.1, 100.0,
                  "pixel size of the camera");
  from.Read("sensor_pixels", o.sensor_pixels, 8, 65536,
            "number of pixels that are read across the line; this limits the measurable depths");
  from.ReadScaled("focus_distance_mm", o.focus_distance_m, kMm, 10.0, 100000.0,
                  "depth at which the camera's axis meets the laser's plane");
  from.ReadScaled("near_mm", o.near_m, kMm, 10.0, 10000.0,
                  "minimum depth; anything nearer to the head is ignored");
  from.ReadScaled("line_width_mm", o.line_width_m, kMm, 0.0, 50.0,
                  "1/e^2 width of the line on a surface");
  from.Read("blur_px", o.blur_px, 0.0, 100.0,
            "1/e^2 width that lens and pixels add to the line's image");
  from.Read("centroid_sigma_px", o.centroid_sigma_px, 0.0, 100.0,
            "white noise of the peak's centroid");
  from.ReadScaled("speckle_sigma_mm", o.speckle_sigma_m, kMm, 0.0, 100.0,
                  "depth noise by speckle at a depth of 1 m, growing with the squared distance");
  from.Read("correlation_samples", o.correlation_samples, 0.01, 10000.0,
            "1/e length of the speckle along the line, in samples");
  from.Read("quantisation_px", o.quantisation_px, 0.0, 100.0,
            "resolution of the centroid; 0: none");
  from.ReadScaled("pan_jitter_deg", o.pan_jitter_rad, kDeg, 0.0, 10.0,
                  "standard deviation of the pan angle, one value per profile");
  ReadSharedKeys(from, o);
}

}  // namespace

LineScannerOptions ReadLineScanner(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string type = kLineScanner;
  map.Read("type", type, {kLineScanner}, "type of the sensor");
  for (const char* key : {"place", "site", "pose", "position"}) {
    if (!map.Has(key)) continue;
    map.Fail(key,
             "a line scanner stands at the scene's site \"scanner\", on the wrist at "
             "\"wrist_scanner\": move that site (scenes/bench.xml has the first)");
  }
  LineScannerOptions options;
  ReadKeys(map, options);
  FinishShared(map, options);
  return options;
}

void CheckOptions(const LineScannerOptions& options) {
  const std::string what = "line scanner";
  const base::RangeCheck check(what);
  ReadKeys(check, options);
  CheckShared(what, options);
}

}  // namespace rangegrasp::sensing
