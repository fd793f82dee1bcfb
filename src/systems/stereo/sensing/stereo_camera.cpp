#include "stereo/sensing/stereo_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sensing/internal/camera_model.h"
#include "sensing/internal/ray_caster.h"
#include "stereo/sensing/internal/lens.h"

namespace rangegrasp::sensing {
namespace {

constexpr float kFarthest_m = 100.0f;  // of what a pixel may show: the room is smaller
constexpr int kMaxLevel = 255;

Eigen::Matrix3d Turned(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

}  // namespace

struct StereoCamera::Impl {
  StereoCameraOptions options;
  stereo::Camera lens;
  internal::LensMap map;
  internal::PixelNoise noise;

  explicit Impl(const StereoCameraOptions& o)
      : options(o), lens(LensOf(o)), map(lens), noise(o.noise_levels * internal::LensMap::kOne) {}

  image::Image Photo(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WC,
                     std::uint64_t seed) const;
};

// Pixels fall off with the square of the distance from the middle, up to the corners' share.
image::Image StereoCamera::Impl::Photo(const sim::World& world, sim::Renderer& renderer,
                                       const base::Pose& X_WC, std::uint64_t seed) const {
  base::Rng rng(base::DeriveSeed(seed, "exposure"));
  const double exposure = std::exp(options.exposure_sigma * rng.Normal());
  image::Image drawn = renderer.Render(world, {X_WC, lens.fx, map.drawn_center_px()});
  internal::Blur(drawn, options.lens_blur_px);
  image::Image photo{lens.width, lens.height, {}};
  photo.rgb.reserve(3 * static_cast<std::size_t>(lens.width) *
                    static_cast<std::size_t>(lens.height));
  const Eigen::Vector2d middle(0.5 * (lens.width - 1), 0.5 * (lens.height - 1));
  constexpr int kGainBits = 12;
  const double fall = options.vignetting / middle.squaredNorm();
  std::vector<std::int32_t> values;
  for (int row = 0; row < lens.height; ++row) {
    map.SampleRow(drawn, row, values);
    for (int column = 0; column < lens.width; ++column) {
      const double from_middle = (Eigen::Vector2d(column, row) - middle).squaredNorm();
      const auto gain =
          static_cast<std::int32_t>((1 << kGainBits) * exposure * (1.0 - fall * from_middle));
      for (std::size_t i = 3 * static_cast<std::size_t>(column), c = 0; c < 3; ++c) {
        values[i + c] = (values[i + c] * gain) >> kGainBits;
      }
    }
    base::Rng row_rng(base::DeriveSeed(seed, static_cast<std::uint64_t>(row)));
    noise.AddTo(values, row_rng);
    for (const std::int32_t value : values) {
      const int level = (value + internal::LensMap::kOne / 2) / internal::LensMap::kOne;
      photo.rgb.push_back(static_cast<std::uint8_t>(std::clamp(level, 0, kMaxLevel)));
    }
  }
  return photo;
}

stereo::Camera LensOf(const StereoCameraOptions& options) {
  stereo::Camera lens;
  lens.width = options.width;
  lens.height = options.height;
  lens.fx = lens.fy = options.focal_px;
  lens.cx = 0.5 * (options.width - 1) + options.center_right_px;
  lens.cy = 0.5 * (options.height - 1) + options.center_down_px;
  lens.k1 = options.k1;
  lens.k2 = options.k2;
  lens.p1 = options.p1;
  lens.p2 = options.p2;
  return lens;
}

base::Pose CameraInHead(const StereoCameraOptions& options, double pan_rad) {
  const Eigen::Vector3d place(options.mount_right_m, options.mount_down_m, options.ahead_m);
  const Eigen::Matrix3d R_PC = Turned(options.mount_yaw_rad, Eigen::Vector3d::UnitY()) *
                               Turned(options.mount_pitch_rad, Eigen::Vector3d::UnitX()) *
                               Turned(options.mount_roll_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d R_SP = internal::PanRotation(pan_rad);
  return base::MakePose(R_SP * R_PC, R_SP * place);
}

StereoNoise ExpectedStereoNoise(const StereoCameraOptions& options, double depth_m, double slope,
                                int window_px) {
  // Of red, green and blue in the grey value (ITU-R BT.601, as OpenCV turns colour into grey).
  const double grey_share = Eigen::Vector3d(0.299, 0.587, 0.114).norm();
  StereoNoise noise;
  noise.baseline_m =
      2.0 * options.ahead_m * std::sin(0.5 * (options.right_pan_rad - options.left_pan_rad));
  noise.disparity_px = options.focal_px * noise.baseline_m / depth_m;
  noise.depth_per_pixel_m = depth_m * depth_m / (options.focal_px * noise.baseline_m);
  noise.matching_px = std::numbers::sqrt2 * grey_share * options.noise_levels / (slope * window_px);
  noise.pan_px = std::numbers::sqrt2 * options.focal_px * options.pan_sigma_rad;
  return noise;
}

StereoCamera::StereoCamera(const StereoCameraOptions& options) {
  CheckOptions(options);
  impl_ = std::make_unique<Impl>(options);
}

StereoCamera::~StereoCamera() = default;

std::unique_ptr<sim::Renderer> StereoCamera::RendererOf(const sim::World& world) const {
  sim::RenderQuality quality;
  quality.samples = impl_->options.edge_samples;
  quality.shadow_px = impl_->options.shadow_px;
  quality.fine_print = impl_->options.fine_print;
  return std::make_unique<sim::Renderer>(world, impl_->map.drawn_width(), impl_->map.drawn_height(),
                                         quality);
}

StereoShot StereoCamera::Photograph(const sim::World& world, const base::Pose& X_WS,
                                    base::Rng& rng) const {
  const auto renderer = RendererOf(world);
  return Photograph(world, *renderer, X_WS, rng);
}

StereoShot StereoCamera::Photograph(const sim::World& world, sim::Renderer& renderer,
                                    const base::Pose& X_WS, base::Rng& rng) const {
  const StereoCameraOptions& options = impl_->options;
  const std::uint64_t seed = rng.Next();
  base::Rng pan(base::DeriveSeed(seed, "pan"));
  StereoShot shot;
  shot.truth.lens = impl_->lens;
  const double left = options.left_pan_rad + options.pan_sigma_rad * pan.Normal();
  const double right = options.right_pan_rad + options.pan_sigma_rad * pan.Normal();
  shot.truth.X_WL = X_WS * CameraInHead(options, left);
  shot.truth.X_WR = X_WS * CameraInHead(options, right);
  shot.photos.left = impl_->Photo(world, renderer, shot.truth.X_WL, base::DeriveSeed(seed, "left"));
  shot.photos.right =
      impl_->Photo(world, renderer, shot.truth.X_WR, base::DeriveSeed(seed, "right"));
  return shot;
}

image::Image StereoCamera::Picture(const sim::World& world, sim::Renderer& renderer,
                                   const base::Pose& X_WC, base::Rng& rng) const {
  return impl_->Photo(world, renderer, X_WC, rng.Next());
}

std::vector<PixelTruth> TruthOfPixels(std::span<const sim::VisualMesh> meshes,
                                      const stereo::Camera& lens, const base::Pose& X_WC,
                                      std::span<const Eigen::Vector2d> pixels) {
  constexpr double kNoRange = std::numeric_limits<double>::quiet_NaN();
  const internal::RayCaster caster(meshes);
  std::vector<internal::Ray> rays;
  std::vector<std::size_t> traced;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector3d ray_C = stereo::RayOf(lens, pixels[i]).normalized();
    if (!ray_C.allFinite()) continue;
    rays.push_back({X_WC.translation().cast<float>(), (X_WC.linear() * ray_C).cast<float>(), 0.0f,
                    kFarthest_m});
    traced.push_back(i);
  }
  std::vector<internal::Hit> hits;
  caster.FirstHits(rays, hits);
  std::vector<PixelTruth> truth(pixels.size(), PixelTruth{0, kNoRange});
  for (std::size_t k = 0; k < traced.size(); ++k) {
    if (!hits[k].found()) continue;
    const double along_axis = rays[k].direction_W.cast<double>().dot(X_WC.linear().col(2));
    truth[traced[k]] = {meshes[hits[k].mesh].label,
                        along_axis * static_cast<double>(hits[k].distance_m)};
  }
  return truth;
}

}  // namespace rangegrasp::sensing
