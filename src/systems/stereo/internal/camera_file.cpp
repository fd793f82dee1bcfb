#include "stereo/internal/camera_file.h"

#include <fmt/format.h>

namespace rangegrasp::stereo::internal {
namespace {

// What a file may hold: far beyond any camera, near enough to find a wrong unit.
constexpr int kMaxSize_px = 16384;
constexpr double kMaxFocalLength_px = 1e6;
constexpr double kMaxDistortion = 100.0;

}  // namespace

void ReadCamera(base::YamlMap& map, Camera& camera) {
  for (const char* key : {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px"}) {
    map.Require(key);
  }
  map.Read("width_px", camera.width, 1, kMaxSize_px, "of its pictures");
  map.Read("height_px", camera.height, 1, kMaxSize_px, "of its pictures");
  map.Read("fx_px", camera.fx, 1.0, kMaxFocalLength_px, "focal length along a row");
  map.Read("fy_px", camera.fy, 1.0, kMaxFocalLength_px, "focal length along a column");
  map.Read("cx_px", camera.cx, 0.0, kMaxSize_px, "column of the principal point");
  map.Read("cy_px", camera.cy, 0.0, kMaxSize_px, "row of the principal point");
  const auto distortion = [&](const char* key, double& value, const char* doc) {
    map.Read(key, value, -kMaxDistortion, kMaxDistortion, doc);
  };
  distortion("k1", camera.k1, "radial distortion, of r^2 (equation 5.10)");
  distortion("k2", camera.k2, "radial distortion, of r^4");
  distortion("k3", camera.k3, "radial distortion, of r^6; not in the dissertation");
  distortion("p1", camera.p1, "tangential distortion");
  distortion("p2", camera.p2, "tangential distortion");
  map.Finish();
}

std::string CameraText(const std::string& name, const Camera& c) {
  return fmt::format(
      "{}:\n  width_px: {}\n  height_px: {}\n  fx_px: {:.17g}\n  fy_px: {:.17g}\n  cx_px: "
      "{:.17g}\n  cy_px: {:.17g}\n  k1: {:.17g}\n  k2: {:.17g}\n  p1: {:.17g}\n  p2: {:.17g}\n  "
      "k3: {:.17g}\n",
      name, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3);
}

}  // namespace rangegrasp::stereo::internal
