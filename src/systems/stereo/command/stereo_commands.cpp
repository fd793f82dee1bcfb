#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/image/image.h"
#include "base/installation.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "geometry/cloud_file.h"
#include "sensing/hand_eye.h"
#include "stereo/calibrate_hand_eye.h"
#include "stereo/pictures.h"
#include "stereo/sensing/internal/simulated_calibration.h"
#include "stereo/sensing/stereo_sensor.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"

namespace rangegrasp::stereo {
namespace {

namespace fs = std::filesystem;

struct StereoArguments {
  std::string left, right, calibration, out, pictures, matching = "semi_global";
  double near_mm = 400.0, far_mm = 1600.0;
  int step_px = 4;
  bool keep_blue = false;
  std::optional<double> table_mm;
};

// With fewer textured windows, rows cannot be checked.
constexpr int kMinTextured = 10;
// Fewer windows may be in their rows by chance: five of the rows searched at first (17) count as
// the same row, so 29 % of the windows that match nowhere are in it.
constexpr int kMinInRow = 3;
// Number of rows searched at first, above and below each window's row.
constexpr int kNearRows = 8;
// Share of the found windows that are in their row if all is right: all but repeated print.
constexpr double kGoodShare = 0.9;
// Share of the picture's height in which rows are searched if the calibration may be wrong.
constexpr double kFarRows = 0.1;

ReconstructOptions OptionsFor(const StereoArguments& a, bool colour) {
  ReconstructOptions options;
  options.match.method = base::FromWord<MatchMethod>(a.matching, "--matching");
  options.near_m = a.near_mm * base::kMm;
  options.far_m = a.far_mm * base::kMm;
  if (options.near_m >= options.far_m) {
    throw base::InputError(
        fmt::format("--near-mm {:g} must be below --far-mm {:g}", a.near_mm, a.far_mm));
  }
  options.step_px = a.step_px;
  options.remove_blue = colour && !a.keep_blue;
  if (a.table_mm) {
    options.table_W = geometry::Plane{Eigen::Vector3d::UnitZ(), -*a.table_mm * base::kMm};
  }
  return options;
}

// With little overlap few windows are found, but most of them are in their row.
bool Fits(const RowOffset& rows) {
  return rows.in_row >= kMinInRow && 2 * rows.in_row >= rows.found;
}

// In pictures from another camera or position, windows are not in the same row.
void CheckRows(const StereoArguments& a, const Reconstruction& made,
               const RectifiedCameras& cameras, const ReconstructOptions& options) {
  const auto measure = [&](int within_rows) {
    return MeasureRowOffset(made.rectified, made.kept, cameras.DisparityAt(options.far_m),
                            cameras.DisparityAt(options.near_m), within_rows);
  };
  RowOffset rows = measure(kNearRows);
  if (rows.textured < kMinTextured) {
    spdlog::warn("{}: only {} places have enough texture to check whether {} belongs to it", a.left,
                 rows.textured, a.calibration);
    return;
  }
  if (Fits(rows)) {
    if (rows.in_row < kGoodShare * rows.found) {
      spdlog::warn(
          "{}: of {} places that were matched in {}, {} are not in the same row: does {} belong to "
          "this camera?",
          a.left, rows.found, a.right, rows.found - rows.in_row, a.calibration);
    }
    return;
  }
  rows = measure(std::max(kNearRows, static_cast<int>(kFarRows * cameras.height)));
  if (Fits(rows)) return;
  throw base::InputError(fmt::format(
      "{}: of {} places with texture in {}, {} were matched in {}, {} of them in the same row "
      "(median: {:.0f} rows off; at most {:g} is right). Either the calibration belongs to another "
      "camera, or the camera was moved: calibrate again (rangegrasp calibrate-stereo). Or the "
      "scene is not between {:g} and {:g} mm: give --near-mm and --far-mm",
      a.calibration, rows.textured, a.left, rows.found, a.right, rows.in_row, rows.median_px,
      kRowTolerance_px, a.near_mm, a.far_mm));
}

// The pixels of the left rectified picture that were removed for their color; outside the original
// picture it is black.
std::ptrdiff_t BluePixels(const Reconstruction& made) {
  const auto& rgb = made.rectified.left.rgb;
  std::ptrdiff_t count = 0;
  for (std::size_t i = 0; i < made.kept.grey.size(); ++i) {
    const bool black = rgb[3 * i] == 0 && rgb[3 * i + 1] == 0 && rgb[3 * i + 2] == 0;
    count += made.kept.grey[i] == 0 && !black;
  }
  return count;
}

void Stereo(const StereoArguments& a) {
  const auto pair = ReadPicturePair(a.left, a.right);
  const auto options = OptionsFor(a, pair.colour);
  const auto calibration = ReadStereoCalibration(a.calibration);
  const Camera& camera = calibration.camera;
  if (pair.left.width != camera.width || pair.left.height != camera.height) {
    throw base::InputError(fmt::format(
        "{} is for a camera with {} x {} pixels, {} has {} x {}: it is the calibration of another "
        "camera",
        a.calibration, camera.width, camera.height, a.left, pair.left.width, pair.left.height));
  }
  const Rectifier rectifier(calibration);
  base::Stopwatch watch;
  const auto made = Reconstruct(pair.left, pair.right, rectifier, options);
  const double seconds = watch.Seconds();
  CheckRows(a, made, rectifier.cameras(), options);
  const auto points = std::ranges::count_if(made.view.image.points_C,
                                            [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (points == 0) {
    throw base::InputError(fmt::format(
        "{} and {}: no pixel was matched between {:g} and {:g} mm; try --near-mm and --far-mm",
        a.left, a.right, a.near_mm, a.far_mm));
  }
  geometry::WriteCloud(a.out, made.view.image);
  if (!a.pictures.empty()) {
    image::WritePng(fs::path(a.pictures) / "disparity.png", DisparityPicture(made.disparity));
  }
  const auto blue = options.remove_blue && !options.table_W ? BluePixels(made) : 0;
  if (blue > 0) {
    spdlog::info("{} (the table) left out: --table-mm or --keep-blue",
                 base::Counted(blue, "blue pixel"));
  }
  spdlog::info("{}, {:.1f} mm apart, {:.0f} ms", base::Counted(points, "point"),
               made.view.spacing_m * base::kMmPerM, seconds * 1e3);
}

void AddStereoCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "stereo", "Make a cloud from two pictures of a calibrated camera, recorded or simulated.");
  auto a = std::make_shared<StereoArguments>();
  command->add_option("left", a->left, "left picture: PNG, 8-bit colour or grey")->required();
  command->add_option("right", a->right, "right picture, in the same format")->required();
  command
      ->add_option("--calibration", a->calibration,
                   "calibration (YAML): the camera, and its pose at each picture")
      ->required();
  command->add_option("-o,--out", a->out, "output cloud in the arm's frame, .pcd or .ply")
      ->required();
  command->add_option("--pictures", a->pictures,
                      "output folder for disparity.png, the disparities in colours");
  command->add_option("--matching", a->matching, "stereo matching method (semi_global)")
      ->check(CLI::IsMember(base::WordList<MatchMethod>()));
  command->add_option("--near-mm", a->near_mm, "minimum depth (400)")
      ->check(cli::NumberBetween(10.0, 1e5));
  command->add_option("--far-mm", a->far_mm, "maximum depth (1600)")
      ->check(cli::NumberBetween(10.0, 1e5));
  command->add_option("--step-px", a->step_px, "distance in pixels between points (4)")
      ->transform(cli::WholeNumber(1, 64));
  command->add_flag("--keep-blue", a->keep_blue,
                    "also match blue pixels (default: they belong to the table)");
  command->add_option("--table-mm", a->table_mm,
                      "height of the table in the arm's frame: blue pixels become points on it");
  command->footer(
      "Example: rangegrasp stereo left.png right.png --calibration stereo.yaml --table-mm 0 -o "
      "pile.pcd");
  command->callback([a] {
    cli::CheckEnding(a->out, {".pcd", ".ply"});
    Stereo(*a);
  });
}

/// Arguments of both calibrations.
struct CalibrateArguments {
  std::string source, out, record, camera, corners = "9x6";
  double square_mm = 25.0;
  int views = 0;
  std::uint64_t seed = 1;
};

/// The help of the options that differ between both calibrations.
struct CalibrateHelp {
  const char* source;
  const char* out;
  const char* camera = nullptr;  ///< null: there is no such option
  const char* views;
  int max_views;
  const char* record;
};

void AddCalibrateOptions(CLI::App& command, CalibrateArguments& a, const CalibrateHelp& help) {
  command.add_option("source", a.source, help.source)->required()->check(CLI::ExistingPath);
  command.add_option("-o,--out", a.out, help.out)->required();
  command.add_option("--corners", a.corners, "inner corners of the chessboard (9x6)");
  command.add_option("--square-mm", a.square_mm, "edge length of its squares (25)")
      ->check(cli::NumberBetween(1.0, 1000.0));
  if (help.camera) {
    command.add_option("--camera", a.camera, help.camera)->check(CLI::ExistingFile);
  }
  command.add_option("--views", a.views, help.views)
      ->transform(cli::WholeNumber(ChessboardOptions{}.min_views, help.max_views));
  command.add_option("--seed", a.seed, "seed of the simulation (1)")->transform(cli::WholeNumber());
  command.add_option("--record", a.record, help.record);
}

ChessboardOptions BoardOf(const CalibrateArguments& a) {
  ChessboardOptions board;
  int used = 0;
  const std::string& text = a.corners;
  if (std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || board.columns < 3 || board.rows < 3) {
    throw base::InputError("--corners '" + text +
                           "' must be COLUMNSxROWS inner corners, at least 3 each, e.g. 9x6");
  }
  board.square_m = a.square_mm * base::kMm;
  return board;
}

fs::path FileOf(const fs::path& folder, const char* what, std::size_t number, const char* ending) {
  return folder / fmt::format("{}_{:02}.{}", what, number, ending);
}

void Write(const BoardView& view, const fs::path& folder, std::size_t number) {
  image::WritePng(FileOf(folder, "left", number, "png"), view.left);
  image::WritePng(FileOf(folder, "right", number, "png"), view.right);
  geometry::WriteCloud(FileOf(folder, "board", number, "pcd"),
                       {.profiles = 1,
                        .samples = static_cast<int>(view.laser_W.size()),
                        .points_C = view.laser_W,
                        .origins_C = {view.laser_origin_W}});
}

BoardView ReadView(const fs::path& folder, std::size_t number) {
  PicturePair pair = ReadPicturePair(FileOf(folder, "left", number, "png"),
                                     FileOf(folder, "right", number, "png"));
  const fs::path file = FileOf(folder, "board", number, "pcd");
  geometry::CloudFile cloud = geometry::ReadCloud(file);
  if (!cloud.sensor_origin) {
    throw base::InputError(file.string() + ": has no VIEWPOINT (the position of the laser)");
  }
  std::erase_if(cloud.points, [](const Eigen::Vector3d& p) { return !p.allFinite(); });
  return {fmt::format("view {}", number), std::move(pair.left), std::move(pair.right),
          std::move(cloud.points), *cloud.sensor_origin};
}

CalibrationResult CalibrateRecorded(const fs::path& folder, const ChessboardOptions& board) {
  std::vector<BoardSighting> boards;
  int width = 0, height = 0;
  for (std::size_t number = 1; fs::exists(FileOf(folder, "left", number, "png")); ++number) {
    const BoardView view = ReadView(folder, number);
    if (number > 1 && (view.left.width != width || view.left.height != height)) {
      throw base::InputError(fmt::format("{}: {} has {} x {} pixels, the first has {} x {}",
                                         folder.string(), view.name, view.left.width,
                                         view.left.height, width, height));
    }
    width = view.left.width;
    height = view.left.height;
    boards.push_back(FindBoard(view, board));
  }
  if (boards.empty()) {
    throw base::InputError(folder.string() +
                           ": does not contain left_01.png, right_01.png, board_01.pcd and so on");
  }
  return CalibrateStereo(boards, width, height, board);
}

CalibrationResult CalibrateInSimulation(const CalibrateArguments& a,
                                        const ChessboardOptions& board) {
  const fs::path source = a.source;
  CalibrationSetup setup{.scene = source, .camera = {}, .views = a.views, .seed = a.seed};
  if (source.extension() == ".yaml" || source.extension() == ".yml") {
    const auto opened = experiment::OpenExperiment(source, {});
    const trial::Cell& cell = trial::CellOf(*opened.task);
    const fs::path camera = CameraFileOf(cell.options);
    if (camera.empty()) throw base::InputError(a.source + ": its sensor is not a stereo camera");
    setup.scene = cell.options.scene;
    setup.scanner = cell.scanner;
    setup.camera = sensing::ReadStereoCamera(camera);
  }
  int number = 0;
  cli::ProgressBar bar(0, a.views);
  return CalibrateSimulated(setup, board, [&](const BoardView& view) {
    ++number;
    if (!a.record.empty()) Write(view, a.record, static_cast<std::size_t>(number));
    if (number <= a.views) return bar(number);
    spdlog::info("view {}: an earlier one is unusable, or all are too similar", number);
  });
}

void Calibrate(const CalibrateArguments& a) {
  const ChessboardOptions board = BoardOf(a);
  const CalibrationResult result = fs::is_directory(a.source) ? CalibrateRecorded(a.source, board)
                                                              : CalibrateInSimulation(a, board);
  WriteStereoCalibration(result.calibration, a.out);
  spdlog::info(
      "{} views: corner error (rms) {:.3f} px for one camera and {:.3f} px for the pair; distance "
      "to the laser's planes {:.2f} mm for one camera, {:.2f} mm triangulated (rms); best fit: "
      "squares of {:.2f} +- {:.2f} mm",
      result.views, result.camera_px, result.stereo_px,
      result.calibration.registration_m * base::kMmPerM, result.triangulated_m * base::kMmPerM,
      result.scale * board.square_m * base::kMmPerM,
      result.scale_error * board.square_m * base::kMmPerM);
}

void AddCalibrateStereoCommand(CLI::App& app) {
  auto* command = app.add_subcommand("calibrate-stereo",
                                     "Calibrate the stereo camera, lens and poses, from a "
                                     "chessboard that the laser also scanned.");
  auto a = std::make_shared<CalibrateArguments>();
  a->views = CalibrationSetup{}.views;
  AddCalibrateOptions(
      *command, *a,
      {.source = "folder with left_01.png, right_01.png, board_01.pcd and so on; or a scene (MJCF) "
                 "or experiment (YAML) to simulate a chessboard in",
       .out = "output calibration (YAML)",
       .views =
           "number of simulated board poses (16); up to twice as many are drawn if they are too "
           "similar",
       .max_views = 200,
       .record = "output folder for the simulated pictures and clouds"});
  command->footer(
      "Example: rangegrasp calibrate-stereo scenes/tabletop.xml -o stereo.yaml --record boards\nA "
      "board's cloud contains the laser points on it in the arm's frame; its VIEWPOINT is the "
      "position of the laser.");
  command->callback([a] { Calibrate(*a); });
}

constexpr char kRecord[] = "views.yaml";
/// An arm with a repeatability of 0.02 deg moves pictures of a lens of 800 px by 0.3 px.
constexpr double kMaxReprojection_px = 1.0;

HandEyeViews Read(const fs::path& folder) {
  HandEyeViews views{.record = ReadHandEyeRecord(folder / kRecord), .pictures = {}};
  const Camera& camera = views.record.camera;
  for (std::size_t i = 1; i <= views.record.X_WH.size(); ++i) {
    const fs::path file = FileOf(folder, "view", i, "png");
    const auto& picture = views.pictures.emplace_back(image::ReadPng<image::Image>(file));
    if (picture.width != camera.width || picture.height != camera.height) {
      throw base::InputError(fmt::format("{}: has {} x {} pixels, the camera of {} has {} x {}",
                                         file.string(), picture.width, picture.height, kRecord,
                                         camera.width, camera.height));
    }
  }
  return views;
}

void Write(const HandEyeViews& views, const fs::path& folder) {
  WriteHandEyeRecord(views.record, folder / kRecord);
  for (std::size_t i = 0; i < views.pictures.size(); ++i) {
    image::WritePng(FileOf(folder, "view", i + 1, "png"), views.pictures[i]);
  }
}

HandEyeViews Simulate(const CalibrateArguments& a, const ChessboardOptions& board) {
  const auto camera = a.camera.empty() ? base::DataFolder() / "models/sensors/wrist_camera.yaml"
                                       : fs::path(a.camera);
  const CalibrationSetup setup{.scene = a.source,
                               .camera = sensing::ReadStereoCamera(camera),
                               .views = a.views,
                               .seed = a.seed};
  int good = 0;
  cli::ProgressBar bar(0, a.views);
  auto views = SimulateHandEye(setup, [&](const image::Image& picture) {
    try {
      FindBoardCorners(picture, "a view", board);
      bar(++good);
      return true;
    } catch (const base::InputError&) {
      return false;
    }
  });
  if (!a.record.empty()) Write(views, a.record);
  return views;
}

HandEyeResult Solve(const HandEyeViews& from, const ChessboardOptions& board) {
  std::vector<HandEyeView> views;
  for (std::size_t i = 0; i < from.pictures.size(); ++i) {
    const std::string name = FileOf("", "view", i + 1, "png").string();
    views.push_back({from.record.X_WH[i], FindBoardCorners(from.pictures[i], name, board)});
  }
  return CalibrateHandEye(views, from.record.camera, board);
}

void CalibrateOnHand(const CalibrateArguments& a) {
  ChessboardOptions board = BoardOf(a);
  board.max_reprojection_px = kMaxReprojection_px;
  const HandEyeViews views = fs::is_directory(a.source) ? Read(a.source) : Simulate(a, board);
  HandEyeResult result;
  try {
    result = Solve(views, board);
  } catch (const base::InputError& error) {
    throw base::InputError(a.source + ": " + error.what());
  }
  const base::Pose X_HS = result.X_HC * views.record.X_SC.inverse();
  sensing::WriteHandEye({X_HS, result.shift_error_m, result.turn_error_rad}, a.out);
  spdlog::info(
      "{} views: corner error {:.3f} px, board error {:.2f} mm (rms); standard errors of the "
      "head's pose {:.2f} mm and {:.3f} deg",
      views.pictures.size(), result.rms_px, result.rms_m * base::kMmPerM,
      result.shift_error_m * base::kMmPerM, result.turn_error_rad / base::kDeg);
  if (!views.X_HS) return;
  const base::Pose apart = views.X_HS->inverse() * X_HS;
  spdlog::info("true error in the simulation: {:.2f} mm and {:.3f} deg",
               apart.translation().norm() * base::kMmPerM,
               base::TurnOf(apart.linear()).angle() / base::kDeg);
}

void AddCalibrateHandEyeCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "calibrate-hand-eye",
      "Calibrate the pose of the sensor on the arm's flange from a chessboard on the table.");
  auto a = std::make_shared<CalibrateArguments>();
  a->views = 25;
  AddCalibrateOptions(
      *command, *a,
      {.source = "folder with views.yaml, view_01.png and so on; or a scene (MJCF) to simulate the "
                 "arm in",
       .out = "output calibration (YAML), for look.hand_eye",
       .camera = "sensor file for the simulation (models/sensors/wrist_camera.yaml)",
       .views = "number of simulated pictures (25)",
       .max_views = 99,
       .record = "output folder for the simulated pictures and poses"});
  command->footer(
      "Example: rangegrasp calibrate-hand-eye scenes/tabletop_wrist.xml -o hand_eye.yaml --record "
      "boards\nviews.yaml contains the lens (camera), the camera's pose in its head (in_head) and "
      "the hand's pose in the arm's frame at each picture (view_01 ...).");
  command->callback([a] { CalibrateOnHand(*a); });
}

}  // namespace
}  // namespace rangegrasp::stereo

namespace rangegrasp {

void RegisterStereo() {
  namespace fs = std::filesystem;
  trial::AddSensor({.word = stereo::kStereoCamera,
                    .states_noise = true,
                    .make = [](const trial::Cell& cell) -> std::unique_ptr<trial::Sensor> {
                      return stereo::StereoOf(cell, cell.options.sensor);
                    }});
  trial::AddSensor({.word = stereo::kLaserAndStereo,
                    .laser = [](const fs::path& file) { return stereo::ReadBoth(file).laser; },
                    .files =
                        [](const fs::path& file) {
                          const stereo::BothFiles both = stereo::ReadBoth(file);
                          return std::vector<fs::path>{both.laser, both.stereo};
                        },
                    .make = [](const trial::Cell& cell) -> std::unique_ptr<trial::Sensor> {
                      return stereo::MakeLaserAndStereo(
                          trial::MakeLineScanner(cell),
                          stereo::StereoOf(cell, stereo::ReadBoth(cell.options.sensor).stereo));
                    }});
  trial::KeyReaders().push_back(stereo::ReadKeys);
  cli::AddLibrary("opencv", RANGEGRASP_OPENCV_VERSION);
  cli::AddCommand(stereo::AddStereoCommand);
  cli::AddCommand(stereo::AddCalibrateHandEyeCommand);
  cli::AddCommand(stereo::AddCalibrateStereoCommand);
}

}  // namespace rangegrasp
