#include "sensing/optics.h"

#include <algorithm>

#include "base/rng.h"

namespace rangegrasp::sensing {
namespace {

using Eigen::Vector3d;

// Below this value the camera's ray and the fan count as parallel: they meet beyond 300 km.
constexpr double kParallel = 1e-6;

// The albedo's corner points are estimates for dark print under a red line.
constexpr double kDarkAlbedo = 0.05;
constexpr double kFairAlbedo = 0.10;
constexpr double kDarkLoss = 0.5;
constexpr double kBlackLoss = 0.9;
constexpr double kInkAlbedo = 0.04;
constexpr double kPaperAlbedo = 0.85;

// Share of the room's light that comes from lamps above; the rest comes from all directions.
constexpr double kFromAbove = 0.5;

// Cell size if each sample is drawn separately: below any spacing.
constexpr double kSinglePlace_m = 1e-5;

Blob Sum(std::span<const Glint> group) {
  Blob blob;
  blob.low_px = group.front().column_px;
  blob.high_px = group.back().column_px;
  double moment = 0.0;
  double brightest = 0.0;
  for (const Glint& glint : group) {
    blob.brightness += glint.brightness;
    moment += glint.brightness * glint.column_px;
    if (glint.brightness > brightest) {
      brightest = glint.brightness;
      blob.source = glint.source;
    }
  }
  if (blob.brightness > 0.0) blob.column_px = moment / blob.brightness;
  return blob;
}

}  // namespace

double PanAngle(const LineScannerOptions& options, int profile) {
  if (options.profiles < 2) return 0.0;
  return options.pan_range_rad * (static_cast<double>(profile) / (options.profiles - 1) - 0.5);
}

Eigen::Matrix3d PanRotation(double pan_rad) {
  return Eigen::AngleAxisd(pan_rad, Vector3d::UnitY()).toRotationMatrix();
}

double Slope(const LineScannerOptions& options, double sample) {
  if (options.samples < 2) return 0.0;
  return std::tan(0.5 * options.fan_rad) * (2.0 * sample / (options.samples - 1) - 1.0);
}

CameraModel::CameraModel(const LineScannerOptions& options)
    : baseline_m_(options.baseline_m),
      sin_(std::sin(std::atan2(options.baseline_m, options.focus_distance_m))),
      cos_(std::cos(std::atan2(options.baseline_m, options.focus_distance_m))),
      scale_px_(options.focal_length_m / options.pixel_pitch_m),
      half_px_(0.5 * options.sensor_pixels),
      half_slope_(std::tan(0.5 * options.fan_rad)),
      line_width_m_(options.line_width_m),
      blur_px_(options.blur_px) {}

bool CameraModel::InView(const Vector3d& p_P) const {
  const double axial_m = AxialDistance(p_P.x(), p_P.z());
  return axial_m > 0.0 && std::abs(p_P.y()) <= half_slope_ * axial_m &&
         OnSensor(Column(p_P.x(), p_P.z()));
}

std::optional<double> CameraModel::Depth(double column_px) const {
  const double q = column_px / scale_px_;
  const double numerator = baseline_m_ * (cos_ + q * sin_);
  const double denominator = sin_ - q * cos_;
  if (numerator <= 0.0 || denominator <= kParallel) return std::nullopt;
  return numerator / denominator;
}

double CameraModel::DepthPerPixel(double depth_m) const {
  const double axial_m = AxialDistance(0.0, depth_m);
  return axial_m * axial_m / (scale_px_ * baseline_m_);
}

double CameraModel::SpotWidth(double axial_distance_m) const {
  return std::hypot(line_width_m_ * scale_px_ / axial_distance_m, blur_px_);
}

double SpeckleSigma(const LineScannerOptions& options) {
  return options.speckle_sigma_m / CameraModel(options).DepthPerPixel(1.0);
}

double CentroidSigma(const LineScannerOptions& options) {
  const double speckle_px = SpeckleSigma(options);
  const double variance_px2 = options.centroid_sigma_px * options.centroid_sigma_px +
                              speckle_px * speckle_px +
                              options.quantisation_px * options.quantisation_px / 12.0;
  return std::sqrt(variance_px2);
}

RayCaster CasterOf(std::span<const sim::VisualMesh> meshes) {
  std::vector<const geometry::TriangleMesh*> surfaces;
  for (const sim::VisualMesh& mesh : meshes) surfaces.push_back(&mesh.mesh_W);
  return RayCaster(surfaces);
}

base::Pose KnownPose(const base::Pose& X_WS, const RangeSensorOptions& options,
                     std::uint64_t seed) {
  base::Rng rng(base::DeriveSeed(seed, "calibration"));
  return X_WS *
         base::DrawRigidError(options.calibration_sigma_m, options.calibration_sigma_rad, rng);
}

double IncidenceLoss(const RangeSensorOptions& options, double incidence_rad) {
  const double span_rad = options.dropout_end_rad - options.dropout_begin_rad;
  return std::clamp((incidence_rad - options.dropout_begin_rad) / span_rad, 0.0, 1.0);
}

double AlbedoLoss(double albedo) {
  if (albedo >= kFairAlbedo) return 0.0;
  if (albedo >= kDarkAlbedo) {
    return kDarkLoss * (kFairAlbedo - albedo) / (kFairAlbedo - kDarkAlbedo);
  }
  return kDarkLoss + (kBlackLoss - kDarkLoss) * (kDarkAlbedo - albedo) / kDarkAlbedo;
}

double GlossLoss(const RangeSensorOptions& options, double gloss, double mirror_offset_rad) {
  return mirror_offset_rad <= options.saturation_angle_rad ? gloss : 0.0;
}

double SampleLoss(double albedo, double clarity) {
  return 1.0 - (1.0 - AlbedoLoss(albedo)) * (1.0 - clarity);
}

double PatchLoss(const RangeSensorOptions& options, double gloss, double incidence_rad,
                 double mirror_offset_rad) {
  return 1.0 - (1.0 - IncidenceLoss(options, incidence_rad)) *
                   (1.0 - GlossLoss(options, gloss, mirror_offset_rad));
}

double PrintAlbedo(std::uint8_t red) {
  return kInkAlbedo + (kPaperAlbedo - kInkAlbedo) * geometry::LightOf({red, 0, 0}).x();
}

double AlbedoAt(const sim::VisualMesh& mesh, const Hit& hit) {
  const auto printed = mesh.colors.PrintAt(hit);
  return printed ? PrintAlbedo((*printed)[0]) : mesh.surface.albedo;
}

Vector3d RoomLight(const sim::VisualMesh& mesh, const Hit& hit) {
  const auto color = mesh.colors.At(hit);
  const double lit = 1.0 - kFromAbove + kFromAbove * std::max(0.0f, hit.normal_W.z());
  return lit * (color ? geometry::LightOf(*color) : Vector3d::Constant(mesh.surface.albedo));
}

Patches::Patches(double size_m, std::uint64_t seed)
    : size_m_(size_m), seed_(base::DeriveSeed(seed, "patch")) {
  base::Rng rng(base::DeriveSeed(seed, "patches"));
  for (double& coordinate : shift_) coordinate = rng.Uniform();
}

bool Patches::IsLost(const Eigen::Vector3f& point_W, double loss) const {
  if (loss <= 0.0) return false;
  std::uint64_t patch = seed_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = static_cast<double>(point_W[axis]);
    // From a grid corner in the origin, rounding would split the table's plane between two layers.
    const double cell = size_m_ > 0.0 ? std::floor(place / size_m_ + shift_[axis])
                                      : std::round(place / kSinglePlace_m);
    patch = base::DeriveSeed(patch, static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)));
  }
  return base::Rng(patch).Uniform() < loss;
}

Blob BrightestBlob(std::span<Glint> glints, double width_px) {
  std::ranges::sort(glints, {}, [](const Glint& g) { return std::pair(g.column_px, g.source); });
  Blob best;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= glints.size(); ++i) {
    if (i < glints.size() && glints[i].column_px - glints[i - 1].column_px <= width_px) continue;
    const Blob blob = Sum(glints.subspan(begin, i - begin));
    if (blob.brightness > best.brightness) best = blob;
    begin = i;
  }
  return best;
}

}  // namespace rangegrasp::sensing
