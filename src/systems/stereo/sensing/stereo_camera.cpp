#include "stereo/sensing/stereo_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "base/yaml_map.h"
#include "sensing/optics.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;

constexpr char kType[] = "stereo_camera";

void ReadKeys(base::YamlMap& from, StereoCameraOptions& o) {
  from.Read("width_px", o.width, 64, 8192, "columns of a picture");
  from.Read("height_px", o.height, 64, 8192, "rows of a picture");
  from.Read("focal_px", o.focal_px, 50.0, 50000.0, "focal length of the lens");
  from.Read("center_right_px", o.center_right_px, -200.0, 200.0,
            "offset of the principal point to the right of the picture's middle");
  from.Read("center_down_px", o.center_down_px, -200.0, 200.0,
            "offset of the principal point below the picture's middle");
  from.Read("k1", o.k1, -0.5, 0.5, "radial distortion (equation 5.10)");
  from.Read("k2", o.k2, -0.5, 0.5, "radial distortion, of the fourth power");
  from.Read("p1", o.p1, -0.05, 0.05, "tangential distortion");
  from.Read("p2", o.p2, -0.05, 0.05, "tangential distortion");
  from.ReadScaled("ahead_mm", o.ahead_m, kMm, 1.0, 2000.0,
                  "distance of the camera in front of the pan axis, which gives the baseline");
  from.ReadScaled("mount_right_mm", o.mount_right_m, kMm, -100.0, 100.0,
                  "position error of the camera, to the right; only a calibration can find it");
  from.ReadScaled("mount_down_mm", o.mount_down_m, kMm, -100.0, 100.0,
                  "position error of the camera, downwards");
  from.ReadScaled("mount_roll_deg", o.mount_roll_rad, kDeg, -10.0, 10.0,
                  "orientation error of the camera, about the viewing direction");
  from.ReadScaled("mount_pitch_deg", o.mount_pitch_rad, kDeg, -10.0, 10.0,
                  "orientation error of the camera, up and down");
  from.ReadScaled("mount_yaw_deg", o.mount_yaw_rad, kDeg, -10.0, 10.0,
                  "orientation error of the camera, left and right");
  from.ReadScaled("left_pan_deg", o.left_pan_rad, kDeg, -45.0, 45.0,
                  "pan angle of the left picture");
  from.ReadScaled("right_pan_deg", o.right_pan_rad, kDeg, -45.0, 45.0,
                  "pan angle of the right picture");
  from.ReadScaled("pan_sigma_deg", o.pan_sigma_rad, kDeg, 0.0, 1.0,
                  "standard deviation of the pan angles, one value per picture");
  from.Read("exposure_sigma", o.exposure_sigma, 0.0, 0.5,
            "relative standard deviation of a picture's exposure");
  from.Read("noise_levels", o.noise_levels, 0.0, 50.0,
            "standard deviation of red, green and blue, of 255");
}

// Standard deviation of the lens's blur, which also smooths the drawn edges.
constexpr double kLensBlur_px = 0.6;
constexpr double kVignetting = 0.25;  // relative loss of light in the corners
constexpr int kShareBits = 8;
constexpr int kShare = 1 << kShareBits;  // steps between two drawn pixels
constexpr int kOneBits = 6;
static_assert(1 << kOneBits == LensMap::kOne);
constexpr int kQuantileBits = 12;  // values end at 3.5 sigma; a word holds five draws
constexpr int kDrawsPerWord = 64 / kQuantileBits;

double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// By Newton's method, from a start that is below the solution for p > 1/2 (the CDF is concave).
double NormalQuantile(double p) {
  if (p < 0.5) return -NormalQuantile(1.0 - p);
  double x = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
    const double step = (p - NormalCdf(x)) / density;
    x += step;
    if (std::abs(step) < 1e-12) break;
  }
  return x;
}

Eigen::Matrix3d Turned(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

}  // namespace

StereoCameraOptions ReadStereoCamera(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string type = kType;
  map.Read("type", type, "type of the sensor: stereo_camera");
  if (type != kType) map.Fail("type", "'" + type + "' must be " + kType);
  StereoCameraOptions options;
  ReadKeys(map, options);
  map.Finish();
  if (options.left_pan_rad >= options.right_pan_rad) {
    map.Fail(map.Has("left_pan_deg") ? "left_pan_deg" : "right_pan_deg",
             "left_pan_deg must be less than right_pan_deg");
  }
  return options;
}

LensMap::LensMap(const stereo::Camera& camera) : width_(camera.width) {
  const std::size_t pixels = image::IndexAt(0, camera.height, camera.width);
  std::vector<Eigen::Vector2f> seen(pixels);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const Eigen::Vector2d place = camera.fx * stereo::RayOf(camera, {x, y}).head<2>();
      if (!place.allFinite()) {
        throw std::invalid_argument(
            "stereo camera: the distortion k1, k2, p1, p2 is so strong that the picture folds over "
            "itself");
      }
      seen[i] = place.cast<float>();
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
  }
  // One pixel of margin, so that each place has four neighbors.
  drawn_center_ = (1.0 - low.array()).ceil();
  const Eigen::Vector2d size = (high + drawn_center_).array().ceil() + 2.0;
  drawn_width_ = static_cast<int>(size.x());
  drawn_height_ = static_cast<int>(size.y());
  places_.reserve(pixels);
  for (const Eigen::Vector2f& place : seen) {
    const Eigen::Array2d at = place.cast<double>() + drawn_center_;
    const Eigen::Array2d whole = at.floor();
    const Eigen::Array2d share = ((at - whole) * kShare).floor();
    places_.push_back(
        {3 * (static_cast<std::uint32_t>(whole.y()) * static_cast<std::uint32_t>(drawn_width_) +
              static_cast<std::uint32_t>(whole.x())),
         static_cast<std::uint16_t>(share.x()), static_cast<std::uint16_t>(share.y())});
  }
}

void LensMap::SampleRow(const image::Image& drawn, int row, std::vector<std::int32_t>& out) const {
  constexpr int kDown = 2 * kShareBits - kOneBits;
  const std::size_t stride = 3 * static_cast<std::size_t>(drawn_width_);
  out.resize(3 * static_cast<std::size_t>(width_));
  const Place* place = places_.data() + image::IndexAt(0, row, width_);
  for (std::size_t i = 0; i < out.size(); i += 3, ++place) {
    const std::uint8_t* upper = drawn.rgb.data() + place->pixel;
    const std::uint8_t* lower = upper + stride;
    const int right = place->right, down = place->down;
    for (int c = 0; c < 3; ++c) {
      const int above = upper[c] * (kShare - right) + upper[c + 3] * right;
      const int below = lower[c] * (kShare - right) + lower[c + 3] * right;
      out[i + static_cast<std::size_t>(c)] = (above * (kShare - down) + below * down) >> kDown;
    }
  }
}

void Blur(image::Image& picture, double sigma_px) {
  // Weights (s, 1 - 2 s, s) have the variance 2 s.
  const int side = static_cast<int>(std::lround(kShare * 0.5 * sigma_px * sigma_px));
  if (side == 0) return;
  const int middle = kShare - 2 * side;
  const std::size_t stride = 3 * static_cast<std::size_t>(picture.width);
  std::vector<std::uint8_t> across(picture.rgb.size());
  const auto smooth = [&](const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to,
                          std::size_t step) {
    std::copy_n(from.begin(), step, to.begin());
    std::copy(from.end() - static_cast<std::ptrdiff_t>(step), from.end(),
              to.end() - static_cast<std::ptrdiff_t>(step));
    for (std::size_t i = step; i + step < from.size(); ++i) {
      to[i] = static_cast<std::uint8_t>(
          (side * (from[i - step] + from[i + step]) + middle * from[i] + kShare / 2) >> kShareBits);
    }
  };
  // The ends of rows mix with those of adjacent rows; they are outside the lens's view.
  smooth(picture.rgb, across, 3);
  smooth(across, picture.rgb, stride);
}

PixelNoise::PixelNoise(double sigma) {
  constexpr int kCount = 1 << kQuantileBits;
  for (int i = 0; i < kCount; ++i) {
    quantiles_.push_back(
        static_cast<std::int32_t>(std::lround(sigma * NormalQuantile((i + 0.5) / kCount))));
  }
}

void PixelNoise::AddTo(std::vector<std::int32_t>& values, base::Rng& rng) const {
  constexpr std::uint64_t kMask = (1 << kQuantileBits) - 1;
  for (std::size_t i = 0; i < values.size();) {
    std::uint64_t bits = rng.Next();
    for (int draw = 0; draw < kDrawsPerWord && i < values.size(); ++draw, ++i) {
      values[i] += quantiles_[bits & kMask];
      bits >>= kQuantileBits;
    }
  }
}

// Light loss grows with the square of the distance from the middle, up to the corners' share.
image::Image StereoCamera::Picture(const sim::World& world, sim::Renderer& renderer,
                                   const base::Pose& X_WC, std::uint64_t seed) const {
  base::Rng rng(base::DeriveSeed(seed, "exposure"));
  const double exposure = std::exp(options_.exposure_sigma * rng.Normal());
  image::Image drawn = renderer.Render(world, {X_WC, lens_.fx, map_.drawn_center_px()});
  Blur(drawn, kLensBlur_px);
  image::Image photo{lens_.width, lens_.height, {}};
  photo.rgb.reserve(3 * image::IndexAt(0, lens_.height, lens_.width));
  const Eigen::Vector2d middle(0.5 * (lens_.width - 1), 0.5 * (lens_.height - 1));
  constexpr int kGainBits = 12;
  const double fall = kVignetting / middle.squaredNorm();
  std::vector<std::int32_t> values;
  for (int row = 0; row < lens_.height; ++row) {
    map_.SampleRow(drawn, row, values);
    for (int column = 0; column < lens_.width; ++column) {
      const double from_middle = (Eigen::Vector2d(column, row) - middle).squaredNorm();
      const auto gain =
          static_cast<std::int32_t>((1 << kGainBits) * exposure * (1.0 - fall * from_middle));
      for (std::size_t i = 3 * static_cast<std::size_t>(column), c = 0; c < 3; ++c) {
        values[i + c] = (values[i + c] * gain) >> kGainBits;
      }
    }
    base::Rng row_rng(base::DeriveSeed(seed, static_cast<std::uint64_t>(row)));
    noise_.AddTo(values, row_rng);
    for (const std::int32_t value : values) {
      const int level = (value + LensMap::kOne / 2) / LensMap::kOne;
      photo.rgb.push_back(static_cast<std::uint8_t>(std::clamp(level, 0, 255)));
    }
  }
  return photo;
}

stereo::Camera LensOf(const StereoCameraOptions& options) {
  return {.width = options.width,
          .height = options.height,
          .fx = options.focal_px,
          .fy = options.focal_px,
          .cx = 0.5 * (options.width - 1) + options.center_right_px,
          .cy = 0.5 * (options.height - 1) + options.center_down_px,
          .k1 = options.k1,
          .k2 = options.k2,
          .p1 = options.p1,
          .p2 = options.p2};
}

base::Pose CameraInHead(const StereoCameraOptions& options, double pan_rad) {
  const Eigen::Vector3d place(options.mount_right_m, options.mount_down_m, options.ahead_m);
  const Eigen::Matrix3d R_PC = Turned(options.mount_yaw_rad, Eigen::Vector3d::UnitY()) *
                               Turned(options.mount_pitch_rad, Eigen::Vector3d::UnitX()) *
                               Turned(options.mount_roll_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d R_SP = PanRotation(pan_rad);
  return base::MakePose(R_SP * R_PC, R_SP * place);
}

StereoCamera::StereoCamera(const StereoCameraOptions& options)
    : options_(options),
      lens_(LensOf(options)),
      map_(lens_),
      noise_(options.noise_levels * LensMap::kOne) {}

std::unique_ptr<sim::Renderer> StereoCamera::RendererOf(const sim::World& world) const {
  return std::make_unique<sim::Renderer>(
      world, map_.drawn_width(), map_.drawn_height(),
      sim::RenderQuality{
          .samples = 0, .shadow_px = options_.shadow_px, .fine_print = options_.fine_print});
}

StereoShot StereoCamera::Photograph(const sim::World& world, const base::Pose& X_WS,
                                    base::Rng& rng) const {
  const auto renderer = RendererOf(world);
  return Photograph(world, *renderer, X_WS, rng);
}

StereoShot StereoCamera::Photograph(const sim::World& world, sim::Renderer& renderer,
                                    const base::Pose& X_WS, base::Rng& rng) const {
  const std::uint64_t seed = rng.Next();
  base::Rng pan(base::DeriveSeed(seed, "pan"));
  StereoShot shot;
  shot.truth.lens = lens_;
  const double left = options_.left_pan_rad + options_.pan_sigma_rad * pan.Normal();
  const double right = options_.right_pan_rad + options_.pan_sigma_rad * pan.Normal();
  shot.truth.X_WL = X_WS * CameraInHead(options_, left);
  shot.truth.X_WR = X_WS * CameraInHead(options_, right);
  shot.photos.left = Picture(world, renderer, shot.truth.X_WL, base::DeriveSeed(seed, "left"));
  shot.photos.right = Picture(world, renderer, shot.truth.X_WR, base::DeriveSeed(seed, "right"));
  return shot;
}

std::vector<PixelTruth> TruthOfPixels(std::span<const sim::VisualMesh> meshes,
                                      const stereo::Camera& lens, const base::Pose& X_WC,
                                      std::span<const Eigen::Vector2d> pixels) {
  constexpr double kNoRange = std::numeric_limits<double>::quiet_NaN();
  constexpr float kFarthest_m = 100.0f;  // maximum range of a pixel: the room is smaller
  const RayCaster caster = CasterOf(meshes);
  std::vector<Ray> rays;
  std::vector<std::size_t> traced;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector3d ray_C = stereo::RayOf(lens, pixels[i]).normalized();
    if (!ray_C.allFinite()) continue;
    rays.push_back({X_WC.translation().cast<float>(), (X_WC.linear() * ray_C).cast<float>(), 0.0f,
                    kFarthest_m});
    traced.push_back(i);
  }
  std::vector<Hit> hits;
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
