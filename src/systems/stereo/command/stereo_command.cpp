#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/output.h"
#include "geometry/cloud_file.h"
#include "stereo/command/stereo_commands.h"
#include "stereo/command/stereo_files.h"
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

// Fewer windows with texture tell nothing about rows.
constexpr int kMinTextured = 10;
// Fewer windows that are found in their rows may be there by chance: of the rows that are searched
// at first (17) five count as the same, so that of windows that fit nowhere 29 % do.
constexpr int kMinInRow = 3;
// Of what is found again, so much stands in its row if all is right: all but what is printed twice.
constexpr double kGoodShare = 0.9;
// The share of the picture's height by which a wrong calibration is looked for.
constexpr double kFarRows = 0.1;

stereo::ReconstructOptions OptionsFor(const StereoArguments& arguments, bool colour) {
  stereo::ReconstructOptions options;
  options.match.method = base::FromWord<stereo::MatchMethod>(arguments.matching, "--matching");
  options.near_m = arguments.near_mm * base::kMm;
  options.far_m = arguments.far_mm * base::kMm;
  if (options.near_m >= options.far_m) {
    throw base::InputError(fmt::format("--near-mm {:g} must be below --far-mm {:g}",
                                       arguments.near_mm, arguments.far_mm));
  }
  options.step_px = arguments.step_px;
  options.remove_blue = colour && !arguments.keep_blue;
  if (arguments.table_mm) {
    options.table_W = geometry::Plane{Eigen::Vector3d::UnitZ(), -*arguments.table_mm * base::kMm};
  }
  return options;
}

// Little overlap leaves few windows, but most of what is found stands in its row.
bool Fits(const stereo::RowOffset& rows) {
  return rows.in_row >= kMinInRow && 2 * rows.in_row >= rows.found;
}

// Pictures that another camera took, or that were taken from elsewhere, do not stand in rows.
void CheckRows(const StereoArguments& arguments, const stereo::Reconstruction& made,
               const stereo::RectifiedCameras& cameras, const stereo::ReconstructOptions& options) {
  stereo::RowSearch search;
  const auto measure = [&] {
    return stereo::MeasureRowOffset(made.rectified, made.kept, cameras.DisparityAt(options.far_m),
                                    cameras.DisparityAt(options.near_m), search);
  };
  stereo::RowOffset rows = measure();
  if (rows.textured < kMinTextured) {
    spdlog::warn("{}: only {} places have texture enough to tell whether {} belongs to it",
                 arguments.left, rows.textured, arguments.calibration);
    return;
  }
  if (Fits(rows)) {
    if (rows.in_row < kGoodShare * rows.found) {
      spdlog::warn(
          "{}: of {} places that were found again in {}, {} are not in the same row: is {} "
          "this camera's?",
          arguments.left, rows.found, arguments.right, rows.found - rows.in_row,
          arguments.calibration);
    }
    return;
  }
  search.rows = std::max(search.rows, static_cast<int>(kFarRows * cameras.height));
  rows = measure();
  if (Fits(rows)) return;
  throw base::InputError(fmt::format(
      "{}: of {} places with texture in {}, {} were found again in {}, {} of them in the same row "
      "(median: {:.0f} rows off; at most {:g} would be right). Either the calibration is another "
      "camera's, or the camera stood elsewhere: calibrate again (rangegrasp calibrate-stereo). Or "
      "what is seen is not between {:g} and {:g} mm: give --near-mm and --far-mm",
      arguments.calibration, rows.textured, arguments.left, rows.found, arguments.right,
      rows.in_row, rows.median_px, search.tolerance_px, arguments.near_mm, arguments.far_mm));
}

void Stereo(const StereoArguments& arguments) {
  const auto pair = stereo::ReadPicturePair(arguments.left, arguments.right);
  const auto options = OptionsFor(arguments, pair.colour);
  const auto calibration = stereo::ReadStereoCalibration(arguments.calibration);
  const stereo::Camera& camera = calibration.camera;
  if (pair.left.width != camera.width || pair.left.height != camera.height) {
    throw base::InputError(fmt::format(
        "{} is of a camera with {} x {} pixels, {} has {} x {}: another camera's calibration",
        arguments.calibration, camera.width, camera.height, arguments.left, pair.left.width,
        pair.left.height));
  }
  const stereo::Rectifier rectifier(calibration);
  base::Stopwatch watch;
  const auto made = stereo::Reconstruct(pair.left, pair.right, rectifier, options);
  const double seconds = watch.Seconds();
  CheckRows(arguments, made, rectifier.cameras(), options);
  const auto points =
      std::count_if(made.view.image.points_C.begin(), made.view.image.points_C.end(),
                    [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (points == 0) {
    throw base::InputError(fmt::format(
        "{} and {}: no pixel was matched between {:g} and {:g} mm; try --near-mm and --far-mm",
        arguments.left, arguments.right, arguments.near_mm, arguments.far_mm));
  }
  geometry::WriteCloud(arguments.out, made.view.image);
  if (!arguments.pictures.empty()) WriteStereoPictures(made, arguments.pictures);
  spdlog::info("{} points, {:.1f} mm apart, {:.0f} ms", points, made.view.spacing_m * base::kMmPerM,
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
      ->check(CLI::IsMember(base::WordList<stereo::MatchMethod>()));
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
  command->callback([arguments] {
    CheckEnding(arguments->out, {".pcd", ".ply"});
    Stereo(*arguments);
  });
}

}  // namespace rangegrasp::cli
