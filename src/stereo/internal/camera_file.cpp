#include "stereo/internal/camera_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/units.h"

namespace rangegrasp::stereo::internal {
namespace {

// What a file may hold: far beyond any camera, near enough to find a wrong unit.
constexpr int kMaxSize_px = 16384;
constexpr double kMaxFocalLength_px = 1e6;
constexpr double kMaxDistortion = 100.0;
constexpr double kMaxDistance_mm = 1e5;
// A quaternion written with five digits is this near to 1.
constexpr double kQuaternionTolerance = 1e-4;

}  // namespace

void ReadCamera(core::YamlMap& map, Camera& camera) {
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

core::Pose ReadPose(core::YamlMap& map, const std::string& of) {
  Eigen::Vector3d position;
  constexpr std::array<const char*, 3> kPositionKeys = {"x_mm", "y_mm", "z_mm"};
  for (int i = 0; i < 3; ++i) {
    const char* key = kPositionKeys[static_cast<std::size_t>(i)];
    map.Require(key);
    map.ReadScaled(key, position[i], core::kMm, -kMaxDistance_mm, kMaxDistance_mm, "origin " + of);
  }
  std::array<double, 4> q{};
  constexpr std::array<const char*, 4> kRotationKeys = {"qw", "qx", "qy", "qz"};
  for (std::size_t i = 0; i < q.size(); ++i) {
    map.Require(kRotationKeys[i]);
    map.Read(kRotationKeys[i], q[i], -1.0, 1.0, "unit quaternion: the axes " + of);
  }
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (std::abs(rotation.norm() - 1.0) > kQuaternionTolerance) {
    map.Fail("qw",
             fmt::format("the quaternion's length is {:.6g}; 1 would be right", rotation.norm()));
  }
  map.Finish();
  return core::MakePose(rotation.normalized().toRotationMatrix(), position);
}

std::string CameraText(const std::string& name, const Camera& c) {
  return fmt::format(
      "{}:\n  width_px: {}\n  height_px: {}\n  fx_px: {:.17g}\n  fy_px: {:.17g}\n  cx_px: "
      "{:.17g}\n  cy_px: {:.17g}\n  k1: {:.17g}\n  k2: {:.17g}\n  p1: {:.17g}\n  p2: {:.17g}\n  "
      "k3: {:.17g}\n",
      name, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3);
}

std::string PoseText(const std::string& name, const core::Pose& pose) {
  const Eigen::Vector3d p = pose.translation() * core::kMmPerM;
  const Eigen::Quaterniond q(pose.rotation());
  return fmt::format(
      "{}:\n  x_mm: {:.17g}\n  y_mm: {:.17g}\n  z_mm: {:.17g}\n  qw: {:.17g}\n  qx: {:.17g}\n  qy: "
      "{:.17g}\n  qz: {:.17g}\n",
      name, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
}

}  // namespace rangegrasp::stereo::internal
