#include "sensing/hand_eye.h"

#include <fmt/format.h>

#include "base/file.h"
#include "base/units.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;
using base::Pose;
using Eigen::Vector3d;

// Maximum distance in a file: far beyond any work cell, but small enough to detect a wrong unit.
constexpr double kMaxDistance_mm = 1e5;
// Rounding error of the length of a quaternion written with five digits.
constexpr double kQuaternionTolerance = 1e-4;

}  // namespace

Pose ReadPoseOf(base::YamlMap& map, const std::string& key) {
  map.Require(key);
  base::YamlMap pose = map.Child(key);
  Vector3d position;
  Eigen::Quaterniond rotation;
  const auto read = [&](const char* name, double& value, double unit, double max) {
    pose.Require(name);
    pose.ReadScaled(name, value, unit, -max, max);
  };
  read("x_mm", position.x(), kMm, kMaxDistance_mm);
  read("y_mm", position.y(), kMm, kMaxDistance_mm);
  read("z_mm", position.z(), kMm, kMaxDistance_mm);
  read("qw", rotation.w(), 1.0, 1.0);
  read("qx", rotation.x(), 1.0, 1.0);
  read("qy", rotation.y(), 1.0, 1.0);
  read("qz", rotation.z(), 1.0, 1.0);
  if (std::abs(rotation.norm() - 1.0) > kQuaternionTolerance) {
    pose.Fail("qw",
              fmt::format("the quaternion's length is {:.6g}; it must be 1", rotation.norm()));
  }
  pose.Finish();
  return base::MakePose(rotation.normalized().toRotationMatrix(), position);
}

std::string PoseText(const std::string& name, const Pose& pose) {
  const Vector3d p = pose.translation() * base::kMmPerM;
  const Eigen::Quaterniond q(pose.rotation());
  return fmt::format(
      "{}:\n  x_mm: {:.17g}\n  y_mm: {:.17g}\n  z_mm: {:.17g}\n  qw: {:.17g}\n  qx: {:.17g}\n  qy: "
      "{:.17g}\n  qz: {:.17g}\n",
      name, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
}

HandEye ReadHandEye(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  HandEye hand_eye;
  hand_eye.X_HS = ReadPoseOf(map, "head");
  map.ReadScaled("error_mm", hand_eye.shift_error_m, kMm, 0.0, 100.0);
  map.ReadScaled("error_deg", hand_eye.turn_error_rad, kDeg, 0.0, 30.0);
  map.Finish();
  return hand_eye;
}

void WriteHandEye(const HandEye& hand_eye, const std::filesystem::path& file) {
  base::WriteFile(file,
                  "# Pose of a sensor's head on the hand (axes of the head: x right, y down, z "
                  "forward), and its\n# standard errors.\n" +
                      PoseText("head", hand_eye.X_HS) +
                      fmt::format("error_mm: {:.17g}\nerror_deg: {:.17g}\n",
                                  hand_eye.shift_error_m / kMm, hand_eye.turn_error_rad / kDeg));
}

}  // namespace rangegrasp::sensing
