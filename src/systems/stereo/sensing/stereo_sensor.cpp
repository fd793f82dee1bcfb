#include "stereo/sensing/stereo_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/image/offscreen_context.h"
#include "base/image/png.h"
#include "base/stopwatch.h"
#include "geometry/cloud_file.h"
#include "stereo/command/stereo_files.h"
#include "trial/cloud_fields.h"

namespace rangegrasp::trial {
namespace {

// What the pixels show that samples come from: for the judge.
sensing::ScanTruth TruthOf(const sim::World& world, const sensing::StereoTruth& lens,
                           const stereo::Reconstruction& made) {
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
    truth.true_range_m.push_back(pixel_truth[i].depth_m *
                                 stereo::RayOf(lens.lens, pixels[i]).norm());
  }
  return truth;
}

std::vector<geometry::Rgb> ColorsAt(const std::vector<Eigen::Vector2f>& pixels,
                                    const image::Image& picture) {
  std::vector<geometry::Rgb> colors(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].allFinite()) continue;
    const int x = std::clamp(static_cast<int>(std::lround(pixels[i].x())), 0, picture.width - 1);
    const int y = std::clamp(static_cast<int>(std::lround(pixels[i].y())), 0, picture.height - 1);
    const std::uint8_t* pixel = picture.At(x, y);
    colors[i] = {pixel[0], pixel[1], pixel[2]};
  }
  return colors;
}

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

const stereo::Rectifier& StereoSensor::rectifier() const {
  Prepare();
  return *rectifier_;
}

const StereoSetup& StereoSensor::setup() const {
  Prepare();
  return setup_;
}

StereoSensor::~StereoSensor() = default;

StereoLook StereoSensor::Look(const sim::World& world, base::Rng& rng) const {
  Prepare();  // before the first picture: it forks, and the renderer has threads from then on
  StereoLook look;
  look.shot = camera_.Photograph(world, X_WScanner_, rng);
  look.made = stereo::Reconstruct(look.shot.photos.left, look.shot.photos.right, rectifier(),
                                  setup_.reconstruct);
  if (setup_.color) {
    look.made.view.colors = ColorsAt(look.made.left_pixel, look.shot.photos.left);
  }
  look.truth = TruthOf(world, look.shot.truth, look.made);
  return look;
}

std::string StereoSensor::WriteLook(const sim::World& world, base::Rng& rng,
                                    const std::filesystem::path& cloud) const {
  base::Stopwatch watch;
  const StereoLook look = Look(world, rng);
  const double seconds = watch.Seconds();
  geometry::WriteCloud(cloud, look.made.view.image, TruthFields(look.made.view, look.truth));
  const auto folder = std::filesystem::path(cloud).replace_extension();
  image::WritePng(folder / "left.png", look.shot.photos.left);
  image::WritePng(folder / "right.png", look.shot.photos.right);
  stereo::WriteStereoCalibration(setup().calibration, folder / "calibration.yaml");
  cli::WriteStereoPictures(look.made, folder);
  return fmt::format(
      "{} points, {:.0f} ms; pictures, disparities and calibration in {}",
      std::count(look.truth.state.begin(), look.truth.state.end(), sensing::SampleState::kMeasured),
      seconds * 1e3, folder.string());
}

Sensed StereoSensor::Sense(const sim::World& world, base::Rng& rng) const {
  StereoLook look = Look(world, rng);
  Sensed sensed;
  sensed.observation.views.push_back(std::move(look.made.view));
  sensed.truth.push_back(std::move(look.truth));
  return sensed;
}

}  // namespace rangegrasp::trial
