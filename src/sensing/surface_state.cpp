#include "sensing/surface_state.h"

#include <cmath>

#include "sensing/internal/camera_model.h"
#include "sensing/internal/ray_caster.h"

namespace rangegrasp::sensing {
namespace {

using internal::Ray;

// Surfaces nearer to a point than this hide it from nothing, so that it may lie on a mesh itself.
constexpr float kLiftOff_m = 0.0005f;

Ray Segment(const Eigen::Vector3d& from_W, const Eigen::Vector3d& to_W, double end_gap_m) {
  const double length_m = (to_W - from_W).norm();
  return {from_W.cast<float>(), ((to_W - from_W) / length_m).cast<float>(), kLiftOff_m,
          static_cast<float>(length_m - end_gap_m)};
}

SurfaceState StateOf(bool lit, bool open_to_camera) {
  if (lit) return open_to_camera ? SurfaceState::kSeen : SurfaceState::kCameraShadow;
  return open_to_camera ? SurfaceState::kLaserShadow : SurfaceState::kBothShadows;
}

}  // namespace

std::vector<SurfaceState> ClassifySurface(geometry::PointSpan points_W,
                                          std::span<const sim::VisualMesh> meshes,
                                          const base::Pose& X_WS,
                                          const LineScannerOptions& options) {
  CheckOptions(options);
  const internal::CameraModel camera(options);
  const internal::RayCaster caster(meshes);
  std::vector<SurfaceState> states(points_W.size(), SurfaceState::kOutOfView);
  std::vector<Ray> to_laser;
  std::vector<Ray> to_camera;
  std::vector<std::size_t> in_sweep;
  const double half_slope = std::tan(0.5 * options.fan_rad);
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const Eigen::Vector3d p_S = X_WS.inverse() * points_W[i];
    const double pan_rad = std::atan2(p_S.x(), p_S.z());
    const Eigen::Vector3d p_P(0.0, p_S.y(), std::hypot(p_S.x(), p_S.z()));
    if (!(std::abs(pan_rad) <= 0.5 * options.pan_range_rad)) continue;
    if (!(std::abs(p_P.y()) <= half_slope * p_P.z()) || !camera.InView(p_P)) continue;
    const Eigen::Vector3d camera_W = X_WS * (internal::PanRotation(pan_rad) * camera.Center());
    to_laser.push_back(Segment(points_W[i], X_WS.translation(), options.near_m));
    to_camera.push_back(Segment(points_W[i], camera_W, options.near_m));
    in_sweep.push_back(i);
  }
  std::vector<std::uint8_t> laser_blocked;
  std::vector<std::uint8_t> camera_blocked;
  caster.Blocked(to_laser, laser_blocked);
  caster.Blocked(to_camera, camera_blocked);
  for (std::size_t k = 0; k < in_sweep.size(); ++k) {
    states[in_sweep[k]] = StateOf(laser_blocked[k] == 0, camera_blocked[k] == 0);
  }
  return states;
}

}  // namespace rangegrasp::sensing
