#include "sensing/depth_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sensing/optics.h"

namespace rangegrasp::sensing {
namespace {

using base::Pose;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kWhite = 0.85;  // albedo to which the stated noise refers
// Minimum reflected light, which keeps the noise finite: less light cannot be measured.
constexpr double kFaint = 0.02;
// Neighbors whose disparity differs by more are two surfaces: a slope of 85 deg at ten baselines.
constexpr float kDisparityEdge_px = 1.0F;
// The same for the depth by time of flight: at 1 m, a slope of 85 deg from pixel to pixel.
constexpr float kDepthEdge = 0.02F;
constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Nearly normal random numbers of mean 0: sums of uniform integers (Irwin and Hall).
constexpr int kUniforms = 4;
constexpr double kUniformSize = 65536.0;
const double kSumSigma = std::sqrt(kUniforms * (kUniformSize * kUniformSize - 1.0) / 12.0);
std::int32_t SumOfUniforms(std::uint64_t bits) {
  constexpr auto kMean = static_cast<std::int32_t>(kUniforms * (kUniformSize - 1.0) / 2.0);
  const std::uint64_t sum =
      (bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48);
  return static_cast<std::int32_t>(sum) - kMean;
}

/// out[i] = sum of the `window` values starting at in[i].
void RunningSum(std::span<const std::int32_t> in, std::span<std::int32_t> out, int window) {
  const std::size_t last = window - 1;
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < last; ++i) sum += in[i];
  for (std::size_t i = 0; i < out.size(); ++i) {
    sum += in[i + last];
    out[i] = sum;
    sum -= in[i];
  }
}

/// Albedo at 850 nm. A print absorbs the near infrared no more than the color that it reflects
/// most; only black absorbs it, too. An estimate.
double InfraredAlbedo(const sim::VisualMesh& mesh, const Hit& hit) {
  const auto printed = mesh.colors.PrintAt(hit);
  return printed ? PrintAlbedo(std::ranges::max(*printed)) : mesh.surface.albedo;
}

/// Normal distribution function, to 0.01 (a logistic curve).
double ShareBelow(double x) { return 1.0 / (1.0 + std::exp(-1.702 * x)); }

/// The share of the noise that remains after averaging images.
double Averaged(const DepthCameraOptions& options) {
  return std::sqrt(options.fixed_share + (1.0 - options.fixed_share) / options.frames);
}

/// The surface that a pixel's ray hits.
struct Pixel {
  float depth_m = kNaN;  ///< along z
  std::uint32_t mesh = kNone;
  float reflected = 0.0F;  ///< albedo times the cosine of incidence
};

/// A depth edge near a pixel.
struct Edge {
  std::uint32_t other = kNone;  ///< the nearest pixel across it
  float distance_px = 0.0F;     ///< to that pixel
};

class Look {
 public:
  Look(std::span<const sim::VisualMesh> meshes, const Pose& X_WS, const DepthCameraOptions& options,
       base::Rng& rng)
      : meshes_(meshes),
        X_WS_(X_WS),
        options_(options),
        caster_(CasterOf(meshes)),
        width_(options.width),
        size_(width_ * options.height),
        focal_px_(FocalLength(options)),
        stereo_(options.principle == DepthPrinciple::kActiveStereo),
        fb_(stereo_ ? focal_px_ * options.baseline_m : 0.0),
        seed_(rng.Next()),
        X_WS_known_(KnownPose(X_WS, options, seed_)),
        patches_(options.dropout_patch_m, seed_),
        disparity_sigma_px_(options.disparity_sigma_px * Averaged(options)),
        sigma_at_1m_(stereo_ ? StereoSigma(options, 1.0)
                             : options.range_sigma_m * Averaged(options) * std::sqrt(kWhite)),
        harmless_{std::cos(options.dropout_begin_rad),
                  std::cos(0.5 * options.saturation_angle_rad)} {}

  Scan Run() {
    Scan scan = EmptyScan(options_.height, options_.width, X_WS_known_);
    MeetSurfaces(scan);
    if (stereo_) HideFromRight(scan);
    FindEdges();
    Measure(scan);
    scan.view.spacing_m = geometry::MedianSpacing(MiddleColumns(scan.view.image));
    if (options_.color) SeeColors(scan.view);
    return scan;
  }

 private:
  double Right(std::size_t column) const {
    return (static_cast<double>(column) + 0.5 - 0.5 * options_.width) / focal_px_;
  }
  double Down(std::size_t row) const {
    return (static_cast<double>(row) + 0.5 - 0.5 * options_.height) / focal_px_;
  }
  std::size_t Rows() const { return options_.height; }

  /// A part of the image that shows all distances. The median of all pixels would take longer.
  geometry::RangeImage MiddleColumns(const geometry::RangeImage& image) const {
    constexpr std::size_t kShare = 16;
    const std::size_t columns = std::max<std::size_t>(width_ / kShare, 2);
    const std::size_t first = std::min(width_ / 2 - width_ / (2 * kShare), width_ - columns);
    geometry::RangeImage middle{image.profiles, static_cast<int>(columns), {}, image.origins_C};
    for (std::size_t row = 0; row < Rows(); ++row) {
      const auto begin = image.points_C.begin() + (row * width_ + first);
      middle.points_C.insert(middle.points_C.end(), begin, begin + columns);
    }
    return middle;
  }

  void MeetSurfaces(Scan& scan) {
    pixels_.resize(size_);
    if (options_.color) light_.assign(size_, Vector3f::Zero());
    constexpr float kRayEnd_m = 100.0F;
    std::vector<Ray> rays(width_);
    std::vector<double> along_rays(width_);  // length of each ray per m of depth
    std::vector<Hit> hits;
    const Vector3f lens_W = X_WS_.translation().cast<float>();
    const Eigen::Matrix3f R_WS = X_WS_.linear().cast<float>();
    for (std::size_t row = 0; row < Rows(); ++row) {
      for (std::size_t column = 0; column < width_; ++column) {
        const Vector3d ray_S(Right(column), Down(row), 1.0);
        along_rays[column] = ray_S.norm();
        rays[column] = {lens_W, R_WS * (ray_S / along_rays[column]).cast<float>(), 0.0F, kRayEnd_m};
      }
      caster_.FirstHits(rays, hits);
      for (std::size_t column = 0; column < width_; ++column) {
        if (!hits[column].found()) continue;
        Meet(row * width_ + column, along_rays[column], rays[column], hits[column], scan);
      }
    }
  }

  void Meet(std::size_t i, double along_ray, const Ray& ray, const Hit& hit, Scan& scan) {
    const sim::VisualMesh& mesh = meshes_[hit.mesh];
    const double albedo = InfraredAlbedo(mesh, hit);
    const double facing = std::abs(hit.normal_W.dot(ray.direction_W));
    Pixel& pixel = pixels_[i];
    pixel.depth_m = static_cast<float>(hit.distance_m / along_ray);
    pixel.mesh = hit.mesh;
    pixel.reflected = static_cast<float>(albedo * facing);
    scan.truth.label[i] = mesh.label;
    scan.truth.true_range_m[i] = hit.distance_m;
    scan.truth.state[i] = SampleState::kMeasured;
    if (options_.color) light_[i] = RoomLight(mesh, hit).cast<float>();
    if (IsLost(i, albedo, facing, ray.origin_W + hit.distance_m * ray.direction_W, mesh.surface)) {
      scan.truth.state[i] = SampleState::kDropout;
    }
  }

  /// The light comes from the camera, so surfaces that face the camera reflect it back.
  bool IsLost(std::size_t i, double albedo, double facing, const Vector3f& point_W,
              const sim::OpticalSurface& surface) const {
    if (facing < harmless_.low || facing > harmless_.high) {
      const double incidence_rad = std::acos(std::min(1.0, facing));
      const double loss = PatchLoss(options_, surface.gloss, incidence_rad, 2.0 * incidence_rad);
      if (patches_.IsLost(point_W, loss)) return true;
    }
    const double sample_loss = SampleLoss(albedo, surface.clarity);
    if (sample_loss <= 0.0) return false;
    return base::Rng(base::DeriveSeed(seed_, std::uint64_t{i})).Uniform() < sample_loss;
  }

  float Disparity(std::size_t i) const {
    return pixels_[i].mesh == kNone ? 0.0F : static_cast<float>(fb_) / pixels_[i].depth_m;
  }

  void HideFromRight(Scan& scan) const {
    std::vector<float> disparity_px(width_);
    for (std::size_t row = 0; row < Rows(); ++row) {
      const std::size_t first = row * width_;
      for (std::size_t c = 0; c < width_; ++c) disparity_px[c] = Disparity(first + c);
      const std::vector<std::uint8_t> hidden = HiddenFromRight(disparity_px);
      for (std::size_t c = 0; c < width_; ++c) {
        if (hidden[c] == 0 || pixels_[first + c].mesh == kNone) continue;
        const bool beyond = static_cast<float>(c) < disparity_px[c];
        scan.truth.state[first + c] = beyond ? SampleState::kOutOfView : SampleState::kCameraShadow;
      }
    }
  }

  bool IsEdge(std::size_t i, std::size_t j) const {
    if (pixels_[i].mesh == kNone || pixels_[j].mesh == kNone) return false;
    const float step = std::abs(pixels_[i].depth_m - pixels_[j].depth_m);
    const float both = pixels_[i].depth_m * pixels_[j].depth_m;
    if (stereo_) return static_cast<float>(fb_) * step > kDisparityEdge_px * both;
    return step * step > kDepthEdge * kDepthEdge * both;
  }

  /// Records the edge for the pixels from `near` on, in the direction away from the edge.
  void Tell(std::size_t near, std::size_t across, std::ptrdiff_t step, std::ptrdiff_t room) {
    for (std::ptrdiff_t k = 0; k < room; ++k) {
      const auto distance_px = static_cast<float>(k + 1);
      if (distance_px > options_.edge_reach_px) return;
      Edge& edge = edges_[near + k * step];
      if (edge.other != kNone && edge.distance_px <= distance_px) continue;
      edge = {static_cast<std::uint32_t>(across), distance_px};
    }
  }

  void FindEdges() {
    edges_.assign(size_, {});
    const std::ptrdiff_t columns = options_.width;
    const std::ptrdiff_t rows = options_.height;
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      for (std::ptrdiff_t column = 0; column < columns; ++column) {
        const std::size_t i = row * columns + column;
        if (column + 1 < columns && IsEdge(i, i + 1)) {
          Tell(i, i + 1, -1, column + 1);
          Tell(i + 1, i, 1, columns - column - 1);
        }
        if (row + 1 < rows && IsEdge(i, i + width_)) {
          Tell(i, i + width_, -columns, row + 1);
          Tell(i + width_, i, columns, rows - row - 1);
        }
      }
    }
  }

  void Measure(Scan& scan) {
    noise_ = stereo_ ? WindowNoise(options_.width, options_.height, options_.window_px,
                                   options_.window_rows_px, seed_)
                     : WindowNoise(options_.width, options_.height, 1, 1, seed_);
    base::Rng rng(base::DeriveSeed(seed_, "offset"));
    offset_m_ = options_.range_offset_m * rng.Normal();
    for (std::size_t row = 0; row < Rows(); ++row) {
      for (std::size_t column = 0; column < width_; ++column) {
        const std::size_t i = row * width_ + column;
        if (scan.truth.state[i] != SampleState::kMeasured) continue;
        const Vector3d ray_S(Right(column), Down(row), 1.0);
        scan.truth.state[i] = MeasurePixel(i, ray_S, scan);
      }
    }
  }

  SampleState MeasurePixel(std::size_t i, const Vector3d& ray_S, Scan& scan) const {
    Pixel seen = pixels_[i];
    if (edges_[i].other != kNone && !CrossEdge(i, seen, scan)) return SampleState::kDropout;
    const double along_ray = ray_S.norm();
    const double depth_m =
        stereo_ ? StereoDepth(seen.depth_m, noise_[i]) : FlightDepth(seen, along_ray, noise_[i]);
    if (!(depth_m >= options_.min_depth_m && depth_m <= options_.max_depth_m)) {
      return SampleState::kOutOfView;
    }
    scan.view.image.points_C[i] =
        X_WS_known_.translation() + depth_m * (X_WS_known_.linear() * ray_S);
    const double sigma_m = stereo_ ? along_ray * depth_m * depth_m * sigma_at_1m_
                                   : FlightNoise(along_ray * depth_m, seen.reflected);
    scan.view.noise_m[i] = static_cast<float>(sigma_m);
    return SampleState::kMeasured;
  }

  /// Decides what a pixel next to a depth edge sees; false: nothing. The decisions use the noise
  /// field, so that they are correlated over a window. Distant values serve as independent draws.
  bool CrossEdge(std::size_t i, Pixel& seen, Scan& scan) const {
    const auto draw = [&](std::size_t k) { return noise_[(i + k * size_ / 5) % size_]; };
    const Edge& edge = edges_[i];
    if (ShareBelow(draw(1)) < options_.edge_loss) return false;
    const Pixel& other = pixels_[edge.other];
    double share = 0.0;  // of the surface across the edge
    if (ShareBelow(draw(2)) < options_.flying_share) {
      share = ShareBelow(draw(3));
    } else if (options_.lateral_sigma_px * draw(4) > edge.distance_px - 0.5) {
      share = 1.0;
    }
    if (share > 0.5) {
      scan.truth.label[i] = meshes_[other.mesh].label;
      scan.truth.true_range_m[i] *= other.depth_m / seen.depth_m;
      seen.mesh = other.mesh;
      seen.reflected = other.reflected;
    }
    seen.depth_m += static_cast<float>(share) * (other.depth_m - seen.depth_m);
    return true;
  }

  double StereoDepth(double depth_m, double draw) const {
    double disparity_px = fb_ / depth_m + disparity_sigma_px_ * draw;
    if (options_.disparity_step_px > 0.0) {
      disparity_px =
          std::nearbyint(disparity_px / options_.disparity_step_px) * options_.disparity_step_px;
    }
    return disparity_px > 0.0 ? fb_ / disparity_px : -1.0;
  }

  double FlightDepth(const Pixel& seen, double along_ray, double draw) const {
    const double range_m = along_ray * seen.depth_m;
    return (range_m + offset_m_ + FlightNoise(range_m, seen.reflected) * draw) / along_ray;
  }

  /// Predicted standard deviation [m] of the range by time of flight. The shot noise is inversely
  /// proportional to the square root of the returned light A ~ albedo cos(i) / range^2 (Lange and
  /// Seitz 2001, "Solid-state time-of-flight range camera"):
  ///   sigma = range_sigma range sqrt(0.85 / (albedo cos(i))) sqrt(s + (1 - s) / frames).
  double FlightNoise(double range_m, double reflected) const {
    return sigma_at_1m_ * range_m / std::sqrt(std::max(reflected, kFaint));
  }

  /// The color camera is next to the lens, and its image is registered to the depth image.
  void SeeColors(geometry::View& view) const {
    base::Rng rng(base::DeriveSeed(seed_, "color"));
    Vector3f gain;
    for (float& channel : gain) {
      channel = static_cast<float>(std::exp(options_.color_gain_sigma * rng.Normal()));
    }
    const double shift_px =
        view.spacing_m > 0.0 ? options_.color_shift_m / std::sqrt(2.0) / view.spacing_m : 0.0;
    const auto right = std::lround(shift_px * rng.Normal());
    const auto down = std::lround(shift_px * rng.Normal());
    view.colors.resize(size_);
    for (std::ptrdiff_t i = 0; i < std::ssize(light_); ++i) {
      const auto row =
          std::clamp<std::ptrdiff_t>(i / options_.width + down, 0, options_.height - 1);
      const auto column =
          std::clamp<std::ptrdiff_t>(i % options_.width + right, 0, options_.width - 1);
      const Vector3f& light = light_[row * options_.width + column];
      view.colors[i] = geometry::ColorOf(gain.cwiseProduct(light).cast<double>());
      for (std::uint8_t& level : view.colors[i]) {
        const double noise = options_.color_noise_levels / kSumSigma * SumOfUniforms(rng.Next());
        level = static_cast<std::uint8_t>(std::clamp(level + noise, 0.0, 255.0) + 0.5);
      }
    }
  }

  std::span<const sim::VisualMesh> meshes_;
  const Pose& X_WS_;
  const DepthCameraOptions& options_;
  RayCaster caster_;
  std::size_t width_, size_;
  double focal_px_;
  bool stereo_;
  double fb_;  ///< focal length times baseline [px m]
  std::uint64_t seed_;
  Pose X_WS_known_;  // as calibrated
  Patches patches_;
  double disparity_sigma_px_;
  double sigma_at_1m_;  ///< for time of flight, with an albedo of 1
  struct {
    double low, high;
  } harmless_;  ///< range of cosines of incidence without lost patches
  double offset_m_ = 0.0;
  std::vector<Pixel> pixels_;
  std::vector<Vector3f> light_;
  std::vector<Edge> edges_;
  std::vector<float> noise_;
};

}  // namespace

double StereoSigma(const DepthCameraOptions& options, double depth_m) {
  const double sigma_px = std::hypot(options.disparity_sigma_px * Averaged(options),
                                     options.disparity_step_px / std::sqrt(12.0));
  return depth_m * depth_m / (FocalLength(options) * options.baseline_m) * sigma_px;
}

std::vector<std::uint8_t> HiddenFromRight(std::span<const float> disparity_px) {
  const std::ptrdiff_t width = std::ssize(disparity_px);
  std::vector<std::ptrdiff_t> place(disparity_px.size());  // in the right image
  for (std::ptrdiff_t column = 0; column < width; ++column) {
    place[column] = std::lrint(static_cast<float>(column) - disparity_px[column]);
  }
  std::vector<float> nearest(disparity_px.size(), 0.0F);  // largest disparity in the right image
  for (std::ptrdiff_t column = 0; column < width; ++column) {
    const float d = disparity_px[column];
    std::ptrdiff_t end = place[column];
    // Closes the gaps in a surface that appears wider in the right image.
    if (column + 1 < width && std::abs(disparity_px[column + 1] - d) <= kDisparityEdge_px) {
      end = std::max(end, place[column + 1] - 1);
    }
    for (auto at = std::max<std::ptrdiff_t>(place[column], 0); at <= end && at < width; ++at) {
      nearest[at] = std::max(nearest[at], d);
    }
  }
  std::vector<std::uint8_t> hidden(disparity_px.size(), 0);
  for (std::ptrdiff_t column = 0; column < width; ++column) {
    const std::ptrdiff_t at = place[column];
    const bool seen = at >= 0 && nearest[at] <= disparity_px[column] + kDisparityEdge_px;
    hidden[column] = seen ? 0 : 1;
  }
  return hidden;
}

std::vector<float> WindowNoise(int width, int height, int window, int rows, std::uint64_t seed) {
  const std::size_t w = width;
  const int all_columns = width + window - 1;
  const int all_rows = height + rows - 1;
  const std::uint64_t noise_seed = base::DeriveSeed(seed, "noise");
  std::uint64_t drawn = 0;
  std::vector<std::int32_t> white(all_columns);
  std::vector<std::int32_t> summed(w * all_rows);
  for (int row = 0; row < all_rows; ++row) {
    for (std::int32_t& value : white) value = SumOfUniforms(base::DeriveSeed(noise_seed, drawn++));
    RunningSum(white, std::span(summed).subspan(row * w, w), window);
  }
  std::vector<std::int32_t> sum(w, 0);
  const auto add = [&](int row, int sign) {
    for (std::size_t c = 0; c < w; ++c) sum[c] += sign * summed[row * w + c];
  };
  for (int row = 0; row + 1 < rows; ++row) add(row, 1);
  const auto scale = static_cast<float>(1.0 / (kSumSigma * std::sqrt(1.0 * window * rows)));
  std::vector<float> noise(w * height);
  for (int row = 0; row < height; ++row) {
    add(row + rows - 1, 1);
    for (std::size_t c = 0; c < w; ++c) noise[row * w + c] = scale * static_cast<float>(sum[c]);
    add(row, -1);
  }
  return noise;
}

Scan ScanScene(std::span<const sim::VisualMesh> meshes, const Pose& X_WS,
               const DepthCameraOptions& options, base::Rng& rng) {
  return Look(meshes, X_WS, options, rng).Run();
}

}  // namespace rangegrasp::sensing
