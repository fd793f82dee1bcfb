#include "sensing/line_scanner.h"

#include <algorithm>

#include "sensing/optics.h"

namespace rangegrasp::sensing {
namespace {

using base::Pose;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A ray of the laser in a profile's frame P: from (x, 0, 0) along (0, slope, 1).
struct LaserRay {
  double x_m;
  double slope;
};

/// The spot of a laser ray on the surface that it hits, and in the camera.
struct Spot {
  Hit hit;
  Vector3f point_W = Vector3f::Zero();
  Vector3f to_laser_W = Vector3f::Zero();       ///< unit
  Vector3f to_camera_W = Vector3f::Zero();      ///< unit
  SampleState state = SampleState::kOutOfView;  ///< kMeasured: the camera sees it
  double column_px = 0.0;
  double axial_m = 0.0;
  double albedo = 0.0;
  double brightness = 0.0;  ///< Lambert's law: albedo times the cosine towards the camera
};

struct ProfilePose {
  Matrix3d R_WP;
  Vector3d laser_W, camera_W;
};

// Length of the laser's rays: beyond everything in a scene.
constexpr float kFarAway_m = 20.0f;
// A ray to the camera starts this far from the surface: above the error of single-precision points
// (0.2 um at 2 m), below the thickness of all objects.
constexpr float kLiftOff_m = 1e-4f;

/// The points on meshes that the laser lights, and whether the camera sees them.
class Illumination {
 public:
  /// @throws std::invalid_argument like CasterOf.
  Illumination(std::span<const sim::VisualMesh> meshes, const LineScannerOptions& options)
      : meshes_(meshes), options_(options), camera_(options), caster_(CasterOf(meshes)) {}

  /// Casts the laser rays of one profile; spots[i] is the spot of rays[i].
  void Light(const ProfilePose& pose, std::span<const LaserRay> rays, std::span<Spot> spots) {
    Cast(pose, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      spots[i] = Spot{};
      spots[i].hit = hits_[i];
      if (hits_[i].found()) MeetSurface(pose, rays[i], rays_W_[i], spots[i]);
    }
    HideBlockedSpots(pose, spots);
  }

  /// Room light that the surfaces reflect where the rays hit them (RoomLight); black without a hit.
  void Show(const ProfilePose& pose, std::span<const LaserRay> rays, std::span<Vector3d> light) {
    Cast(pose, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      light[i].setZero();
      if (!hits_[i].found()) continue;
      light[i] = RoomLight(meshes_[hits_[i].mesh], hits_[i]);
    }
  }

 private:
  void Cast(const ProfilePose& pose, std::span<const LaserRay> rays) {
    rays_W_.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Vector3d direction_P = Vector3d(0.0, rays[i].slope, 1.0).normalized();
      rays_W_[i] = {(pose.laser_W + rays[i].x_m * pose.R_WP.col(0)).cast<float>(),
                    (pose.R_WP * direction_P).cast<float>(), static_cast<float>(options_.near_m),
                    kFarAway_m};
    }
    caster_.FirstHits(rays_W_, hits_);
  }

  void MeetSurface(const ProfilePose& pose, const LaserRay& ray, const Ray& ray_W,
                   Spot& spot) const {
    const double range_m = spot.hit.distance_m;
    const double z_m = range_m / std::sqrt(1.0 + ray.slope * ray.slope);
    const Vector3d point_P(ray.x_m, ray.slope * z_m, z_m);
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

  void HideBlockedSpots(const ProfilePose& pose, std::span<Spot> spots) {
    camera_rays_W_.clear();
    camera_ray_spot_.clear();
    const Vector3f camera_W = pose.camera_W.cast<float>();
    for (std::size_t i = 0; i < spots.size(); ++i) {
      if (spots[i].state != SampleState::kMeasured) continue;
      const float far_m =
          (camera_W - spots[i].point_W).norm() - static_cast<float>(options_.near_m);
      camera_rays_W_.push_back({spots[i].point_W, spots[i].to_camera_W, kLiftOff_m, far_m});
      camera_ray_spot_.push_back(i);
    }
    caster_.Blocked(camera_rays_W_, blocked_);
    for (std::size_t k = 0; k < blocked_.size(); ++k) {
      if (blocked_[k] != 0) spots[camera_ray_spot_[k]].state = SampleState::kCameraShadow;
    }
  }

  std::span<const sim::VisualMesh> meshes_;
  const LineScannerOptions& options_;
  CameraModel camera_;
  RayCaster caster_;
  // Buffers of Light, kept to avoid allocations.
  std::vector<Ray> rays_W_, camera_rays_W_;
  std::vector<Hit> hits_;
  std::vector<std::size_t> camera_ray_spot_;
  std::vector<std::uint8_t> blocked_;
};

// Neighboring samples further than this from each other's tangent plane have an edge between them:
// the line's width. Less costs rays on curved surfaces; more leaves small steps too sharp.
constexpr float kEdge_m = 0.001f;
// Minimum step of albedo that shifts the line's centroid noticeably: 0.1 in 0.5 shifts it by at
// most a fifth of half the line's width. A smaller value would cost rays on every print.
constexpr double kAlbedoStep = 0.1;
// If a smaller share of the line's light is in view, the camera finds no peak. An estimate: a
// larger value widens the shadows' borders, by less than the line's width.
constexpr double kFaintShare = 0.15;

/// Sample points across the line (in its widths; Gaussian, 1/e^2 at 0.5) and along one sample.
constexpr std::array<double, 5> kAcross = {-0.6, -0.3, 0.0, 0.3, 0.6};
constexpr std::array<double, 3> kAlong = {-1.0 / 3.0, 0.0, 1.0 / 3.0};

// exp(-8 a^2): 1/e^2 at a = 0.5.
double LineWeight(double across) { return std::exp(-8.0 * across * across); }

class Sweep {
 public:
  Sweep(std::span<const sim::VisualMesh> meshes, const Pose& X_WS,
        const LineScannerOptions& options, base::Rng& rng)
      : meshes_(meshes),
        X_WS_(X_WS),
        options_(options),
        camera_(options),
        illumination_(meshes, options),
        noise_seed_(rng.Next()),
        X_WS_known_(KnownPose(X_WS, options, noise_seed_)),
        patches_(options.dropout_patch_m, noise_seed_),
        first_slope_(sensing::Slope(options, 0.0)),
        slope_step_(sensing::Slope(options, 1.0) - first_slope_) {}

  Scan Run() {
    const std::vector<ProfilePose> poses = JitteredPoses();
    CastMainRays(poses);
    MarkEdges();
    Scan scan = EmptyScan(options_.profiles, options_.samples, X_WS_known_);
    for (std::size_t profile = 0; profile < Profiles(); ++profile) {
      Refine(poses[profile], profile);
      Measure(profile, scan);
    }
    if (options_.color) SeeColors(poses, scan.view);
    scan.view.spacing_m = geometry::MedianSpacing(scan.view.image);
    return scan;
  }

 private:
  std::size_t Samples() const { return options_.samples; }
  std::size_t Profiles() const { return options_.profiles; }
  double Slope(double sample) const { return first_slope_ + slope_step_ * sample; }
  std::vector<LaserRay> Rays(double across_m, double along) const {
    std::vector<LaserRay> rays;
    for (int i = 0; i < options_.samples; ++i) rays.push_back({across_m, Slope(i) + along});
    return rays;
  }

  std::vector<ProfilePose> JitteredPoses() const {
    base::Rng jitter(base::DeriveSeed(noise_seed_, "pan"));
    std::vector<ProfilePose> poses(Profiles());
    for (int profile = 0; profile < options_.profiles; ++profile) {
      const double pan_rad =
          PanAngle(options_, profile) + options_.pan_jitter_rad * jitter.Normal();
      ProfilePose& pose = poses[profile];
      pose.R_WP = X_WS_.linear() * PanRotation(pan_rad);
      pose.laser_W = X_WS_.translation();
      pose.camera_W = pose.laser_W + pose.R_WP * camera_.Center();
    }
    return poses;
  }

  void CastMainRays(std::span<const ProfilePose> poses) {
    const std::vector<LaserRay> rays = Rays(0.0, 0.0);
    spots_.resize(Profiles() * Samples());
    for (std::size_t profile = 0; profile < Profiles(); ++profile) {
      illumination_.Light(poses[profile], rays,
                          std::span(spots_).subspan(profile * Samples(), Samples()));
    }
  }

  bool IsEdge(const Spot& a, const Spot& b) const {
    if (!a.hit.found() || !b.hit.found()) return a.hit.found() != b.hit.found();
    if (a.state != b.state || std::abs(a.albedo - b.albedo) > kAlbedoStep) return true;
    const Vector3f step_W = b.point_W - a.point_W;
    return std::abs(a.hit.normal_W.dot(step_W)) > kEdge_m ||
           std::abs(b.hit.normal_W.dot(step_W)) > kEdge_m;
  }

  void MarkEdges() {
    edge_.assign(spots_.size(), 0);
    const auto compare = [this](std::size_t i, std::size_t j) {
      if (IsEdge(spots_[i], spots_[j])) edge_[i] = edge_[j] = 1;
    };
    for (std::size_t profile = 0; profile < Profiles(); ++profile) {
      for (std::size_t sample = 0; sample < Samples(); ++sample) {
        const std::size_t i = profile * Samples() + sample;
        if (sample + 1 < Samples()) compare(i, i + 1);
        if (profile + 1 < Profiles()) compare(i, i + Samples());
      }
    }
  }

  /// Samples the line's width at the marked samples of a profile.
  void Refine(const ProfilePose& pose, std::size_t profile) {
    std::vector<LaserRay> rays;
    std::vector<std::size_t> marked;
    for (int sample = 0; sample < options_.samples; ++sample) {
      const std::size_t i = profile * Samples() + sample;
      if (edge_[i] == 0) continue;
      marked.push_back(i);
      for (const double across : kAcross) {
        for (const double along : kAlong) {
          rays.push_back({across * options_.line_width_m, Slope(sample + along)});
        }
      }
    }
    std::vector<Spot> parts(rays.size());
    illumination_.Light(pose, rays, parts);
    const std::size_t n = kAcross.size() * kAlong.size();
    for (std::size_t k = 0; k < marked.size(); ++k) {
      Spot& spot = spots_[marked[k]];
      spot = Merge(std::span<const Spot>(parts).subspan(k * n, n), spot);
    }
  }

  Spot Merge(std::span<const Spot> parts, const Spot& main) const {
    std::array<Glint, kAcross.size() * kAlong.size()> glints;
    std::size_t count = 0;
    double seen = 0.0, all = 0.0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double weight = LineWeight(kAcross[i / kAlong.size()]);
      all += weight;
      if (parts[i].state != SampleState::kMeasured) continue;
      seen += weight;
      glints[count++] = {parts[i].column_px, weight * parts[i].brightness, i};
    }
    if (seen < kFaintShare * all) {
      Spot faint = main;
      if (faint.state == SampleState::kMeasured) faint.state = SampleState::kCameraShadow;
      return faint;
    }
    const double width_px = camera_.SpotWidth(parts[glints[0].source].axial_m);
    const Blob blob = BrightestBlob(std::span(glints).first(count), width_px);
    // The truth is the nominal ray's own spot if it is part of the peak and on the same surface.
    const Spot& brightest = parts[blob.source];
    const bool own = main.state == SampleState::kMeasured && main.hit.mesh == brightest.hit.mesh &&
                     main.column_px >= blob.low_px && main.column_px <= blob.high_px;
    Spot merged = own ? main : brightest;
    if (blob.brightness > 0.0) merged.column_px = blob.column_px;
    return merged;
  }

  void Measure(std::size_t profile, Scan& scan) const {
    base::Rng rng(base::DeriveSeed(noise_seed_, profile));
    const Matrix3d R_WP =
        X_WS_known_.linear() * PanRotation(PanAngle(options_, static_cast<int>(profile)));
    const double kept = std::exp(-1.0 / options_.correlation_samples);
    const double fresh = std::sqrt(1.0 - kept * kept);
    const double speckle_sigma_px = SpeckleSigma(options_);
    const double centroid_sigma_px = CentroidSigma(options_);
    double speckle = rng.Normal();  // stationary from the first sample
    for (int sample = 0; sample < options_.samples; ++sample) {
      speckle = kept * speckle + fresh * rng.Normal();
      const double white = rng.Normal();
      const double dropout_draw = rng.Uniform();
      const std::size_t i = profile * Samples() + sample;
      const Spot& spot = spots_[i];
      if (!spot.hit.found()) continue;
      const double slope = Slope(sample);
      Vector3d& point_W = scan.view.image.points_C[i];
      scan.truth.state[i] =
          MeasureSample(spot, options_.centroid_sigma_px * white + speckle_sigma_px * speckle,
                        dropout_draw, slope, R_WP, point_W);
      if (scan.truth.state[i] == SampleState::kMeasured) {
        const double depth_m = R_WP.col(2).dot(point_W - X_WS_known_.translation());
        const double along_ray = std::sqrt(1.0 + slope * slope);  // ray length per m of depth
        scan.view.noise_m[i] =
            static_cast<float>(centroid_sigma_px * camera_.DepthPerPixel(depth_m) * along_ray);
      }
      scan.truth.label[i] = meshes_[spot.hit.mesh].label;
      scan.truth.true_range_m[i] = spot.hit.distance_m;
    }
  }

  SampleState MeasureSample(const Spot& spot, double noise_px, double dropout_draw, double slope,
                            const Matrix3d& R_WP, Vector3d& point_W) const {
    if (spot.state != SampleState::kMeasured) return spot.state;
    const Vector3f mirrored_W =
        2.0f * spot.hit.normal_W.dot(spot.to_laser_W) * spot.hit.normal_W - spot.to_laser_W;
    const auto angle = [](const Vector3f& a, const Vector3f& b) {
      return static_cast<double>(std::acos(std::clamp(a.dot(b), -1.0f, 1.0f)));
    };
    const sim::OpticalSurface& surface = meshes_[spot.hit.mesh].surface;
    const double patch_loss =
        PatchLoss(options_, surface.gloss, angle(spot.hit.normal_W, spot.to_laser_W),
                  angle(mirrored_W, spot.to_camera_W));
    if (dropout_draw < SampleLoss(spot.albedo, surface.clarity) ||
        patches_.IsLost(spot.point_W, patch_loss)) {
      return SampleState::kDropout;
    }
    double column_px = spot.column_px + noise_px;
    if (options_.quantisation_px > 0.0) {
      column_px = std::round(column_px / options_.quantisation_px) * options_.quantisation_px;
    }
    const std::optional<double> depth_m = camera_.Depth(column_px);
    if (!camera_.OnSensor(column_px) || !depth_m) return SampleState::kOutOfView;
    point_W = X_WS_known_.translation() + *depth_m * (R_WP.col(2) + slope * R_WP.col(1));
    return SampleState::kMeasured;
  }

  /// The second exposure, for colors.
  void SeeColors(std::span<const ProfilePose> poses, geometry::View& view) {
    base::Rng rng(base::DeriveSeed(noise_seed_, "color"));
    const double shift_m = options_.color_shift_m / std::sqrt(2.0);
    const double across_m = shift_m * rng.Normal();
    const double along = shift_m / options_.focus_distance_m * rng.Normal();
    Vector3d gain;
    for (double& channel : gain) channel = std::exp(options_.color_gain_sigma * rng.Normal());
    const std::vector<LaserRay> rays = Rays(across_m, along);
    std::vector<Vector3d> light(rays.size());
    view.colors.reserve(spots_.size());
    for (const ProfilePose& pose : poses) {
      illumination_.Show(pose, rays, light);
      for (const Vector3d& one : light) {
        geometry::Rgb color = geometry::ColorOf(gain.cwiseProduct(one));
        for (std::uint8_t& level : color) {
          const double noisy = level + options_.color_noise_levels * rng.Normal();
          level = static_cast<std::uint8_t>(std::lround(std::clamp(noisy, 0.0, 255.0)));
        }
        view.colors.push_back(color);
      }
    }
  }

  std::span<const sim::VisualMesh> meshes_;
  const Pose& X_WS_;
  const LineScannerOptions& options_;
  CameraModel camera_;
  Illumination illumination_;
  std::uint64_t noise_seed_;
  Pose X_WS_known_;  // as calibrated
  Patches patches_;
  double first_slope_, slope_step_;
  std::vector<Spot> spots_;  // one per sample
  std::vector<std::uint8_t> edge_;
};

// Surfaces nearer to a point than this do not hide it, so that the point may lie on a mesh itself.
constexpr float kOwnSurface_m = 0.0005f;

Ray Segment(const Vector3d& from_W, const Vector3d& to_W, double end_gap_m) {
  const double length_m = (to_W - from_W).norm();
  return {from_W.cast<float>(), ((to_W - from_W) / length_m).cast<float>(), kOwnSurface_m,
          static_cast<float>(length_m - end_gap_m)};
}

SurfaceState StateOf(bool lit, bool open_to_camera) {
  if (lit) return open_to_camera ? SurfaceState::kSeen : SurfaceState::kCameraShadow;
  return open_to_camera ? SurfaceState::kLaserShadow : SurfaceState::kBothShadows;
}

}  // namespace

double DepthSigma(const LineScannerOptions& options, double depth_m) {
  return CameraModel(options).DepthPerPixel(depth_m) * CentroidSigma(options);
}

Scan ScanScene(std::span<const sim::VisualMesh> meshes, const Pose& X_WS,
               const LineScannerOptions& options, base::Rng& rng) {
  CheckOptions(options);
  return Sweep(meshes, X_WS, options, rng).Run();
}

std::vector<SurfaceState> ClassifySurface(geometry::PointSpan points_W,
                                          std::span<const sim::VisualMesh> meshes, const Pose& X_WS,
                                          const LineScannerOptions& options) {
  CheckOptions(options);
  const CameraModel camera(options);
  const RayCaster caster = CasterOf(meshes);
  std::vector<SurfaceState> states(points_W.size(), SurfaceState::kOutOfView);
  std::vector<Ray> to_laser, to_camera;
  std::vector<std::size_t> in_sweep;
  const double half_slope = std::tan(0.5 * options.fan_rad);
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const Vector3d p_S = X_WS.inverse() * points_W[i];
    const double pan_rad = std::atan2(p_S.x(), p_S.z());
    const Vector3d p_P(0.0, p_S.y(), std::hypot(p_S.x(), p_S.z()));
    if (!(std::abs(pan_rad) <= 0.5 * options.pan_range_rad)) continue;
    if (!(std::abs(p_P.y()) <= half_slope * p_P.z()) || !camera.InView(p_P)) continue;
    const Vector3d camera_W = X_WS * (PanRotation(pan_rad) * camera.Center());
    to_laser.push_back(Segment(points_W[i], X_WS.translation(), options.near_m));
    to_camera.push_back(Segment(points_W[i], camera_W, options.near_m));
    in_sweep.push_back(i);
  }
  std::vector<std::uint8_t> laser_blocked, camera_blocked;
  caster.Blocked(to_laser, laser_blocked);
  caster.Blocked(to_camera, camera_blocked);
  for (std::size_t k = 0; k < in_sweep.size(); ++k) {
    states[in_sweep[k]] = StateOf(laser_blocked[k] == 0, camera_blocked[k] == 0);
  }
  return states;
}

}  // namespace rangegrasp::sensing
