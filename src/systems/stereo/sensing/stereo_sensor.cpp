#include "stereo/sensing/stereo_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/image/image.h"
#include "base/image/offscreen_context.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "geometry/cloud_file.h"
#include "geometry/kd_tree.h"
#include "perception/preprocess.h"
#include "stereo/pictures.h"
#include "stereo/sensing/internal/simulated_calibration.h"

namespace rangegrasp::stereo {
namespace {

namespace fs = std::filesystem;
using geometry::Points;
using geometry::RangeImage;

/// A stereo sample within this many gaps of a returned laser ray, as seen from the laser, adds
/// nothing: it is already measured, the laser saw through it, or it is behind what the laser saw.
/// Smaller: single lost rays are also filled; larger: absorbing surfaces lose a wider border.
constexpr double kGaps = 1.0;
/// Geometrical filter, in spacings of the stereo samples, as in PreprocessOptions: the unit of
/// length of eq. 4.8, and the distance of a neighbor that no outlier has. Otherwise, nearly all
/// evenly spaced samples would be outliers.
constexpr double kUnitSpacings = 0.34;
constexpr double kKeepSpacings = 1.3;

/// The keys below `stereo` of grasping experiments, and their name in trial::Options.
struct Keys {
  ReconstructOptions reconstruct;
  fs::path calibration;  ///< of the camera; empty: calibrated before the first trial
};
constexpr const char* kKeys = "stereo";

/// Distance of both pictures below which depths mean nothing: with 2,000 px of focal length, a
/// pixel of disparity at 0.5 m is then 0.1 m of depth.
constexpr double kMinSideways_m = 0.001;

/// A camera that takes a pair. Another one, e.g. on the hand, would be refused only after its
/// calibration, by a message without its file.
sensing::StereoCameraOptions ReadPairCamera(const fs::path& file) {
  const auto camera = sensing::ReadStereoCamera(file);
  const base::Pose X_SL = sensing::CameraInHead(camera, camera.left_pan_rad);
  const base::Pose X_SR = sensing::CameraInHead(camera, camera.right_pan_rad);
  const double sideways_m = (X_SL.inverse() * X_SR.translation()).x();
  if (sideways_m >= kMinSideways_m) return camera;
  throw base::InputError(fmt::format(
      "{}: its right picture is taken {:.2g} mm to the right of its left one, at least {:g} mm are "
      "needed for depths: correct ahead_mm or the pan angles, or choose another sensor",
      file.string(), sideways_m * base::kMmPerM, kMinSideways_m * base::kMmPerM));
}

// Ground truth of the samples' pixels, for the judge.
sensing::ScanTruth TruthOf(const sim::World& world, const sensing::StereoTruth& lens,
                           const Reconstruction& made) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(made.left_pixel.size());
  for (const auto& pixel : made.left_pixel) pixels.push_back(pixel.cast<double>());
  const auto pixel_truth =
      sensing::TruthOfPixels(world.VisualMeshes(), lens.lens, lens.X_WL, pixels);
  sensing::ScanTruth truth;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool measured = made.view.image.points_C[i].allFinite();
    truth.state.push_back(measured ? sensing::SampleState::kMeasured
                                   : sensing::SampleState::kDropout);
    truth.label.push_back(pixel_truth[i].label);
    truth.true_range_m.push_back(pixel_truth[i].depth_m * RayOf(lens.lens, pixels[i]).norm());
  }
  return truth;
}

std::vector<geometry::Rgb> ColorsAt(const std::vector<Eigen::Vector2f>& pixels,
                                    const image::Image& picture) {
  std::vector<geometry::Rgb> colors(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].allFinite()) continue;
    const std::uint8_t* pixel = NearestPixel(picture, pixels[i].cast<double>());
    colors[i] = {pixel[0], pixel[1], pixel[2]};
  }
  return colors;
}

// Unit directions from the sensor; NaN where nothing was measured.
Points Directions(const RangeImage& image) {
  Points directions;
  directions.reserve(image.points_C.size());
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    directions.push_back((image.points_C[i] - image.OriginOf(i)).normalized());
  }
  return directions;
}

// Median distance of unit directions that are a number of samples apart; 0 if there are none.
double MedianStep(const Points& directions, std::size_t apart) {
  std::vector<double> steps;
  for (std::size_t i = 0; i + apart < directions.size(); ++i) {
    const double step = (directions[i + apart] - directions[i]).norm();
    if (std::isfinite(step)) steps.push_back(step);
  }
  return steps.empty() ? 0.0 : base::MedianOf(std::move(steps));
}

// Keeps only samples that no returned laser ray passes.
void ForgetSeen(const geometry::View& laser, const RangeImage& stereo, std::vector<bool>& kept) {
  const Points all = Directions(laser.image);
  Points returned = all;
  std::erase_if(returned, [](const Eigen::Vector3d& d) { return !d.allFinite(); });
  if (returned.empty()) return;
  const double reach =
      kGaps * std::max(MedianStep(all, 1),
                       MedianStep(all, static_cast<std::size_t>(std::max(1, laser.image.samples))));
  const geometry::KdTree tree(returned);
  // A laser turns about its exit point, so all of its rays have the same origin.
  const Eigen::Vector3d origin = laser.image.OriginOf(0);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    const Eigen::Vector3d direction = (stereo.points_C[i] - origin).normalized();
    kept[i] = tree.CountWithin(direction, reach, 1) == 0;
  }
}

void ForgetOutliers(const RangeImage& stereo, std::vector<bool>& kept) {
  geometry::Indices index;
  Points points;
  for (std::uint32_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    index.push_back(i);
    points.push_back(stereo.points_C[i]);
  }
  if (points.size() < 2) return;
  kept.assign(kept.size(), false);
  perception::OutlierFilterOptions filter;
  const double spacing_m = geometry::MedianSpacing(stereo);
  filter.unit_m = std::max(filter.unit_m, kUnitSpacings * spacing_m);
  filter.keep_m = kKeepSpacings * spacing_m;
  for (const auto k : perception::CompressionRateFilter(points, filter)) kept[index[k]] = true;
}

// Samples that are left out count as not measured, also for the judge.
void LeaveOut(const std::vector<bool>& kept, geometry::View& view, sensing::ScanTruth& truth) {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]) continue;
    view.image.points_C[i].setConstant(std::numeric_limits<double>::quiet_NaN());
    if (!view.noise_m.empty()) view.noise_m[i] = std::numeric_limits<float>::quiet_NaN();
    truth.state[i] = sensing::SampleState::kDropout;
  }
}

class LaserAndStereo : public trial::Sensor {
 public:
  LaserAndStereo(std::unique_ptr<trial::Sensor> laser, std::unique_ptr<trial::Sensor> stereo)
      : laser_(std::move(laser)), stereo_(std::move(stereo)) {}

  void Prepare() const override { stereo_->Prepare(); }
  void Rehearse(const sim::World& world) const override { stereo_->Rehearse(world); }
  bool Rehearses() const override { return true; }

  trial::Sensed Sense(const sim::World& world, base::Rng& rng) const override {
    base::Rng same = rng;
    trial::Sensed sensed = laser_->Sense(world, rng);
    trial::Sensed filling = stereo_->Sense(world, same);
    geometry::View& view = filling.observation.views.front();
    LeaveOut(FillsAbsorbed(sensed.observation.views.front(), view), view, filling.truth.front());
    sensed.observation.views.push_back(std::move(view));
    sensed.truth.push_back(std::move(filling.truth.front()));
    return sensed;
  }

 private:
  std::unique_ptr<trial::Sensor> laser_, stereo_;
};

}  // namespace

StereoSensor::StereoSensor(StereoSetup setup, const base::Pose& X_WScanner)
    : setup_(std::move(setup)), X_WScanner_(X_WScanner), camera_(setup_.camera) {
  if (!setup_.calibrate) Prepare();
}

void StereoSensor::Prepare() const {
  if (rectifier_) return;
  if (setup_.calibrate) setup_.calibration = setup_.calibrate();
  rectifier_.emplace(setup_.calibration);
}

void StereoSensor::Rehearse(const sim::World& world) const {
  if (!image::DrawBeforeForking()) return;
  base::Rng rng(0);
  camera_.Photograph(world, X_WScanner_, rng);
}

const StereoSetup& StereoSensor::setup() const {
  Prepare();
  return setup_;
}

StereoLook StereoSensor::Look(const sim::World& world, base::Rng& rng) const {
  Prepare();  // before the first picture: it forks, and the renderer has threads from then on
  StereoLook look;
  look.shot = camera_.Photograph(world, X_WScanner_, rng);
  look.made =
      Reconstruct(look.shot.photos.left, look.shot.photos.right, *rectifier_, setup_.reconstruct);
  if (setup_.color) {
    look.made.view.colors = ColorsAt(look.made.left_pixel, look.shot.photos.left);
  }
  look.truth = TruthOf(world, look.shot.truth, look.made);
  return look;
}

std::string StereoSensor::WriteLook(const sim::World& world, base::Rng& rng,
                                    const fs::path& cloud) const {
  base::Stopwatch watch;
  const StereoLook look = Look(world, rng);
  const double seconds = watch.Seconds();
  geometry::WriteCloud(cloud, look.made.view.image, trial::TruthFields(look.made.view, look.truth));
  const auto folder = fs::path(cloud).replace_extension();
  image::WritePng(folder / "left.png", look.shot.photos.left);
  image::WritePng(folder / "right.png", look.shot.photos.right);
  WriteStereoCalibration(setup().calibration, folder / "calibration.yaml");
  image::WritePng(folder / "disparity.png", DisparityPicture(look.made.disparity));
  const auto points = std::ranges::count(look.truth.state, sensing::SampleState::kMeasured);
  return fmt::format("{}, {:.0f} ms; pictures, disparities and calibration in {}",
                     base::Counted(points, "point"), seconds * 1e3, folder.string());
}

trial::Sensed StereoSensor::Sense(const sim::World& world, base::Rng& rng) const {
  StereoLook look = Look(world, rng);
  trial::Sensed sensed;
  sensed.observation.views.push_back(std::move(look.made.view));
  sensed.truth.push_back(std::move(look.truth));
  return sensed;
}

void ReadKeys(base::YamlMap& map, trial::Options& options) {
  auto own = map.Child("stereo", "stereo reconstruction: from a pair of pictures to a cloud");
  Keys& keys = trial::Of<Keys>(options, kKeys);
  own.ReadPath("calibration", keys.calibration,
               "calibration of the camera; default: calibrate it before the first trial");
  ReadReconstructOptions(own, keys.reconstruct);
}

BothFiles ReadBoth(const fs::path& sensor_file) {
  BothFiles files;
  auto map = base::YamlMap::FromFile(sensor_file);
  std::string type;
  map.Read("type", type);
  for (const char* key : {"laser", "stereo"}) map.Require(key);
  map.ReadPath("laser", files.laser, "file of the line scanner");
  map.ReadPath("stereo", files.stereo, "file of the stereo camera");
  map.Finish();
  return files;
}

fs::path CameraFileOf(const trial::Options& options) {
  if (options.sensor_type == kStereoCamera) return options.sensor;
  return options.sensor_type == kLaserAndStereo ? ReadBoth(options.sensor).stereo : fs::path();
}

std::unique_ptr<StereoSensor> StereoOf(const trial::Cell& cell, const fs::path& camera) {
  const trial::Options& options = cell.options;
  const Keys keys = trial::Of<Keys>(options, kKeys);
  StereoSetup setup;
  setup.camera = ReadPairCamera(camera);
  if (keys.calibration.empty()) {
    const CalibrationSetup calibration{.scene = options.scene,
                                       .camera = setup.camera,
                                       .scanner = cell.scanner,
                                       .seed = base::DeriveSeed(options.seed, "calibration")};
    setup.calibrate = [calibration] { return CalibrateApart(calibration); };
  } else {
    setup.calibration = ReadStereoCalibration(keys.calibration);
  }
  setup.reconstruct = keys.reconstruct;
  setup.color = options.color;
  setup.reconstruct.table_W = cell.TablePlane();
  setup.reconstruct.volume = {
      .X_WV = cell.robot.X_WWorkspace,
      .radius_m = cell.robot.workspace_radius_m + options.workspace_margin_m,
      .height_m = keys.reconstruct.volume_height_m};
  return std::make_unique<StereoSensor>(std::move(setup), cell.robot.X_WScanner);
}

std::vector<bool> FillsAbsorbed(const geometry::View& laser, const geometry::View& stereo) {
  std::vector<bool> kept;
  for (const Eigen::Vector3d& p : stereo.image.points_C) kept.push_back(p.allFinite());
  ForgetSeen(laser, stereo.image, kept);
  ForgetOutliers(stereo.image, kept);
  return kept;
}

std::unique_ptr<trial::Sensor> MakeLaserAndStereo(std::unique_ptr<trial::Sensor> laser,
                                                  std::unique_ptr<trial::Sensor> stereo) {
  return std::make_unique<LaserAndStereo>(std::move(laser), std::move(stereo));
}

}  // namespace rangegrasp::stereo
