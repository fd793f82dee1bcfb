#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sensing/internal/camera_model.h"
#include "sensing/internal/ray_caster.h"
#include "sensing/scan_truth.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing::internal {

/// A ray of the laser in a profile's frame P: from (x, 0, 0) along (0, slope, 1).
struct LaserRay {
  double x_m;
  double slope;
};

/// What a laser ray makes on the surface it meets, and in the camera.
struct Spot {
  Hit hit;
  Eigen::Vector3f point_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f to_laser_W = Eigen::Vector3f::Zero();   ///< unit
  Eigen::Vector3f to_camera_W = Eigen::Vector3f::Zero();  ///< unit
  SampleState state = SampleState::kOutOfView;            ///< kMeasured: the camera sees it
  double column_px = 0.0;
  double axial_m = 0.0;
  double albedo = 0.0;
  double brightness = 0.0;  ///< Lambert's law: albedo, and the cosine towards the camera
};

/// The head at one profile.
struct ProfilePose {
  Eigen::Matrix3d R_WP;
  Eigen::Vector3d laser_W;
  Eigen::Vector3d camera_W;
};

/// What the laser lights on a set of meshes, and what of it the camera sees. Keeps references to
/// its arguments; one thread at a time.
class Illumination {
 public:
  /// @throws std::invalid_argument as RayCaster.
  Illumination(std::span<const sim::VisualMesh> meshes, const LineScannerOptions& options)
      : meshes_(meshes), options_(options), camera_(options), caster_(meshes) {}

  /// Lights the surfaces by rays of one profile; spots[i] is what rays[i] makes.
  void Light(const ProfilePose& pose, std::span<const LaserRay> rays, std::span<Spot> spots);
  /// What the room's light, half of it from above, shows of the surfaces that the rays meet: each
  /// channel 0..1; black where they meet none.
  void Show(const ProfilePose& pose, std::span<const LaserRay> rays,
            std::span<Eigen::Vector3d> light);

 private:
  void Cast(const ProfilePose& pose, std::span<const LaserRay> rays);
  void MeetSurface(const ProfilePose& pose, const LaserRay& ray, const Ray& ray_W,
                   Spot& spot) const;
  void HideBlockedSpots(const ProfilePose& pose, std::span<Spot> spots);

  std::span<const sim::VisualMesh> meshes_;
  const LineScannerOptions& options_;
  CameraModel camera_;
  RayCaster caster_;
  // Buffers of Light, kept for their memory.
  std::vector<Ray> rays_W_;
  std::vector<Hit> hits_;
  std::vector<Ray> camera_rays_W_;
  std::vector<std::size_t> camera_ray_spot_;
  std::vector<std::uint8_t> blocked_;
};

}  // namespace rangegrasp::sensing::internal
