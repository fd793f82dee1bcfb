#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/stereo_files.h"
#include "core/error.h"
#include "core/stopwatch.h"
#include "core/units.h"
#include "core/words.h"
#include "geometry/cloud_file.h"
#include "stereo/pictures.h"
#include "stereo/reconstruct.h"

namespace rangegrasp::cli {
namespace {

struct StereoArguments {
  std::string left, right, calibration, out, pictures, matching = "semi_global";
  double near_mm = 400.0, far_mm = 1600.0;
  int step_px = 4;
  bool keep_blue = false;
  std::optional<double> table_mm;
};

// Rows may differ by this much: rectification with a calibration that fits leaves a fraction of a
// pixel, and half a window hides it.
constexpr double kMaxRowOffset_px = 2.0;
// Fewer windows that were found again tell nothing about rows.
constexpr int kMinWindows = 10;

stereo::ReconstructOptions OptionsFor(const StereoArguments& arguments, bool colour) {
  stereo::ReconstructOptions options;
  options.match.method = core::FromWord<stereo::MatchMethod>(arguments.matching, "--matching");
  options.near_m = arguments.near_mm * core::kMm;
  options.far_m = arguments.far_mm * core::kMm;
  if (options.near_m >= options.far_m) {
    throw core::InputError(fmt::format("--near-mm {:g} must be below --far-mm {:g}",
                                       arguments.near_mm, arguments.far_mm));
  }
  options.step_px = arguments.step_px;
  options.remove_blue = colour && !arguments.keep_blue;
  if (arguments.table_mm) {
    options.table_W = geometry::Plane{Eigen::Vector3d::UnitZ(), -*arguments.table_mm * core::kMm};
  }
  return options;
}

// Pictures that another camera took, or that were taken from elsewhere, do not stand in rows.
void CheckRows(const StereoArguments& arguments, const stereo::Reconstruction& made,
               const stereo::RectifiedCameras& cameras, const stereo::ReconstructOptions& options) {
  const auto rows =
      stereo::MeasureRowOffset(made.rectified, made.kept, cameras.DisparityAt(options.far_m),
                               cameras.DisparityAt(options.near_m));
  if (rows.windows < kMinWindows) {
    spdlog::warn("only {} places of the left picture were found again in the right one",
                 rows.windows);
    return;
  }
  if (std::abs(rows.median_px) <= kMaxRowOffset_px) return;
  throw core::InputError(fmt::format(
      "{}: what is in one row of {} lies {:.0f} rows off in {} (median of {} places; at most "
      "{:.0f} "
      "would be right): the calibration is another camera's, or the camera stood elsewhere",
      arguments.calibration, arguments.left, rows.median_px, arguments.right, rows.windows,
      kMaxRowOffset_px));
}

void Stereo(const StereoArguments& arguments) {
  const auto pair = stereo::ReadPicturePair(arguments.left, arguments.right);
  const auto options = OptionsFor(arguments, pair.colour);
  const auto calibration = stereo::ReadStereoCalibration(arguments.calibration);
  const stereo::Camera& camera = calibration.camera;
  if (pair.left.width != camera.width || pair.left.height != camera.height) {
    throw core::InputError(fmt::format(
        "{} is of a camera with {} x {} pixels, {} has {} x {}: another camera's calibration",
        arguments.calibration, camera.width, camera.height, arguments.left, pair.left.width,
        pair.left.height));
  }
  const stereo::Rectifier rectifier(calibration);
  core::Stopwatch watch;
  const auto made = stereo::Reconstruct(pair.left, pair.right, rectifier, options);
  const double seconds = watch.Seconds();
  CheckRows(arguments, made, rectifier.cameras(), options);
  const auto points =
      std::count_if(made.view.image.points_C.begin(), made.view.image.points_C.end(),
                    [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (points == 0) {
    throw core::InputError(fmt::format(
        "{} and {}: no pixel was matched between {:g} and {:g} mm; try --near-mm and --far-mm",
        arguments.left, arguments.right, arguments.near_mm, arguments.far_mm));
  }
  geometry::WriteCloud(arguments.out, made.view.image);
  if (!arguments.pictures.empty()) WriteStereoPictures(made, arguments.pictures);
  spdlog::info("{} points, {:.1f} mm apart, {:.0f} ms", points, made.view.spacing_m * core::kMmPerM,
               seconds * 1e3);
}

}  // namespace

void AddStereoCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "stereo", "A cloud from two pictures of a calibrated camera, recorded ones too.");
  auto arguments = std::make_shared<StereoArguments>();
  command->add_option("left", arguments->left, "PNG, 8-bit colour or grey")->required();
  command->add_option("right", arguments->right, "the same from further right")->required();
  command
      ->add_option("--calibration", arguments->calibration,
                   "YAML: the camera, and where it stood at each picture")
      ->required();
  command->add_option("-o,--out", arguments->out, "cloud in the arm's frame, .pcd or .ply")
      ->required();
  command->add_option("--pictures", arguments->pictures,
                      "folder for rectified.png, disparity.png (colours) and disparity16.png "
                      "(256 levels a pixel)");
  command->add_option("--matching", arguments->matching, "what finds the disparities (semi_global)")
      ->check(CLI::IsMember(core::WordList<stereo::MatchMethod>()));
  command->add_option("--near-mm", arguments->near_mm, "nearest depth that is searched (400)")
      ->check(CLI::Range(10.0, 1e5));
  command->add_option("--far-mm", arguments->far_mm, "furthest depth that is searched (1600)")
      ->check(CLI::Range(10.0, 1e5));
  command->add_option("--step-px", arguments->step_px, "one point for so many pixels (4)")
      ->check(CLI::Range(1, 64));
  command->add_flag("--keep-blue", arguments->keep_blue,
                    "match blue pixels, too, which are the table's else");
  command->add_option("--table-mm", arguments->table_mm,
                      "height of the table in the arm's frame: blue pixels become points on it");
  command->footer(
      "Example: rangegrasp stereo left.png right.png --calibration stereo.yaml --table-mm 0 -o "
      "pile.pcd");
  command->callback([arguments] { Stereo(*arguments); });
}

}  // namespace rangegrasp::cli
