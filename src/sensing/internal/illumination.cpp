#include "sensing/internal/illumination.h"

#include <algorithm>
#include <cmath>

#include "sensing/internal/reflection.h"

namespace rangegrasp::sensing::internal {
namespace {

// Where rays of the laser end: beyond everything that a scene holds.
constexpr float kFarAway_m = 20.0f;
// A ray to the camera starts this far from the surface, so that it does not meet where it starts:
// above the error of single-precision points (0.2 um at 2 m), below the thickness of all things.
constexpr float kLiftOff_m = 1e-4f;

// Of the room's light so much comes from lamps above, the rest from everywhere: faces that are seen
// from aside are half as bright as those that face the lamps.
constexpr double kFromAbove = 0.5;

double AlbedoAt(const sim::VisualMesh& mesh, const Hit& hit) {
  const auto printed = mesh.colors.PrintAt(hit);
  return printed ? PrintAlbedo((*printed)[0]) : mesh.surface.albedo;
}

// What is of no known color is grey.
Eigen::Vector3d LightFrom(const sim::VisualMesh& mesh, const Hit& hit) {
  const auto color = mesh.colors.At(hit);
  return color ? geometry::LightOf(*color) : Eigen::Vector3d::Constant(mesh.surface.albedo);
}

}  // namespace

void Illumination::Cast(const ProfilePose& pose, std::span<const LaserRay> rays) {
  rays_W_.resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d direction_P = Eigen::Vector3d(0.0, rays[i].slope, 1.0).normalized();
    rays_W_[i] = {(pose.laser_W + rays[i].x_m * pose.R_WP.col(0)).cast<float>(),
                  (pose.R_WP * direction_P).cast<float>(), static_cast<float>(options_.near_m),
                  kFarAway_m};
  }
  caster_.FirstHits(rays_W_, hits_);
}

void Illumination::Show(const ProfilePose& pose, std::span<const LaserRay> rays,
                        std::span<Eigen::Vector3d> light) {
  Cast(pose, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    light[i].setZero();
    if (!hits_[i].found()) continue;
    const double lit = 1.0 - kFromAbove + kFromAbove * std::max(0.0f, hits_[i].normal_W.z());
    light[i] = lit * LightFrom(meshes_[hits_[i].mesh], hits_[i]);
  }
}

void Illumination::Light(const ProfilePose& pose, std::span<const LaserRay> rays,
                         std::span<Spot> spots) {
  Cast(pose, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    spots[i] = Spot{};
    spots[i].hit = hits_[i];
    if (hits_[i].found()) MeetSurface(pose, rays[i], rays_W_[i], spots[i]);
  }
  HideBlockedSpots(pose, spots);
}

void Illumination::MeetSurface(const ProfilePose& pose, const LaserRay& ray, const Ray& ray_W,
                               Spot& spot) const {
  const double range_m = spot.hit.distance_m;
  const double z_m = range_m / std::sqrt(1.0 + ray.slope * ray.slope);
  const Eigen::Vector3d point_P(ray.x_m, ray.slope * z_m, z_m);
  spot.point_W = ray_W.origin_W + ray_W.direction_W * spot.hit.distance_m;
  spot.to_laser_W = -ray_W.direction_W;
  spot.albedo = AlbedoAt(meshes_[spot.hit.mesh], spot.hit);
  spot.to_camera_W = (pose.camera_W.cast<float>() - spot.point_W).normalized();
  if (!camera_.InView(point_P)) return;
  const float facing = spot.hit.normal_W.dot(spot.to_camera_W);
  if (facing <= 0.0f) {
    spot.state = SampleState::kCameraShadow;
    return;
  }
  spot.state = SampleState::kMeasured;
  spot.axial_m = camera_.AxialDistance(point_P.x(), point_P.z());
  spot.column_px = camera_.Column(point_P.x(), point_P.z());
  spot.brightness = spot.albedo * static_cast<double>(facing);
}

void Illumination::HideBlockedSpots(const ProfilePose& pose, std::span<Spot> spots) {
  camera_rays_W_.clear();
  camera_ray_spot_.clear();
  const Eigen::Vector3f camera_W = pose.camera_W.cast<float>();
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (spots[i].state != SampleState::kMeasured) continue;
    const float far_m = (camera_W - spots[i].point_W).norm() - static_cast<float>(options_.near_m);
    camera_rays_W_.push_back({spots[i].point_W, spots[i].to_camera_W, kLiftOff_m, far_m});
    camera_ray_spot_.push_back(i);
  }
  caster_.Blocked(camera_rays_W_, blocked_);
  for (std::size_t k = 0; k < blocked_.size(); ++k) {
    if (blocked_[k] != 0) spots[camera_ray_spot_[k]].state = SampleState::kCameraShadow;
  }
}

}  // namespace rangegrasp::sensing::internal
