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

/// The chessboard as the command line names it.
struct ChessboardArgument {
  std::string corners = "9x6";
  double square_mm = 25.0;
};

void AddBoardOptions(CLI::App& command, ChessboardArgument& argument) {
  command.add_option("--corners", argument.corners, "inner corners of the board (9x6)");
  command.add_option("--square-mm", argument.square_mm, "edge of its squares (25)")
      ->check(CLI::Range(1.0, 1000.0));
}

ChessboardOptions BoardOf(const ChessboardArgument& argument) {
  ChessboardOptions board;
  int used = 0;
  const std::string& text = argument.corners;
  if (std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || board.columns < 3 || board.rows < 3) {
    throw base::InputError("--corners '" + text +
                           "' must be COLUMNSxROWS inner corners, 3 each at least, e.g. 9x6");
  }
  board.square_m = argument.square_mm * base::kMm;
  return board;
}

struct StereoArguments {
  std::string left, right, calibration, out, pictures, matching = "semi_global";
  double near_mm = 400.0, far_mm = 1600.0;
  int step_px = 4;
  bool keep_blue = false;
  std::optional<double> table_mm;
};

// Fewer windows with texture say nothing about rows.
constexpr int kMinTextured = 10;
// Fewer windows that are found in their rows may be there by chance: of the rows that are searched
// at first (17) five count as the same, so that of windows that fit nowhere 29 % do.
constexpr int kMinInRow = 3;
// Of what is found again, so much stands in its row if all is right: all but what is printed twice.
constexpr double kGoodShare = 0.9;
// The share of the picture's height by which a wrong calibration is looked for.
constexpr double kFarRows = 0.1;

ReconstructOptions OptionsFor(const StereoArguments& arguments, bool colour) {
  ReconstructOptions options;
  options.match.method = base::FromWord<MatchMethod>(arguments.matching, "--matching");
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
bool Fits(const RowOffset& rows) {
  return rows.in_row >= kMinInRow && 2 * rows.in_row >= rows.found;
}

// Pictures that another camera took, or that were taken from elsewhere, do not stand in rows.
void CheckRows(const StereoArguments& arguments, const Reconstruction& made,
               const RectifiedCameras& cameras, const ReconstructOptions& options) {
  RowSearch search;
  const auto measure = [&] {
    return MeasureRowOffset(made.rectified, made.kept, cameras.DisparityAt(options.far_m),
                            cameras.DisparityAt(options.near_m), search);
  };
  RowOffset rows = measure();
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
  const auto pair = ReadPicturePair(arguments.left, arguments.right);
  const auto options = OptionsFor(arguments, pair.colour);
  const auto calibration = ReadStereoCalibration(arguments.calibration);
  const Camera& camera = calibration.camera;
  if (pair.left.width != camera.width || pair.left.height != camera.height) {
    throw base::InputError(fmt::format(
        "{} is of a camera with {} x {} pixels, {} has {} x {}: another camera's calibration",
        arguments.calibration, camera.width, camera.height, arguments.left, pair.left.width,
        pair.left.height));
  }
  const Rectifier rectifier(calibration);
  base::Stopwatch watch;
  const auto made = Reconstruct(pair.left, pair.right, rectifier, options);
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
      ->check(CLI::IsMember(base::WordList<MatchMethod>()));
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
    cli::CheckEnding(arguments->out, {".pcd", ".ply"});
    Stereo(*arguments);
  });
}

struct CalibrateArguments {
  std::string source, out, record;
  ChessboardArgument board;
  int views = CalibrationSetup{}.views;
  std::uint64_t seed = 1;
};

std::filesystem::path FileOf(const std::filesystem::path& folder, const char* what, int number,
                             const char* ending) {
  return folder / fmt::format("{}_{:02}.{}", what, number, ending);
}

void Write(const BoardView& view, const std::filesystem::path& folder, int number) {
  image::WritePng(FileOf(folder, "left", number, "png"), view.left);
  image::WritePng(FileOf(folder, "right", number, "png"), view.right);
  geometry::RangeImage board;
  board.profiles = 1;
  board.samples = static_cast<int>(view.laser_W.size());
  board.points_C = view.laser_W;
  board.origins_C = {view.laser_origin_W};
  geometry::WriteCloud(FileOf(folder, "board", number, "pcd"), board);
}

BoardView ReadView(const std::filesystem::path& folder, int number) {
  BoardView view;
  view.name = fmt::format("view {}", number);
  PicturePair pair = ReadPicturePair(FileOf(folder, "left", number, "png"),
                                     FileOf(folder, "right", number, "png"));
  view.left = std::move(pair.left);
  view.right = std::move(pair.right);
  const std::filesystem::path file = FileOf(folder, "board", number, "pcd");
  geometry::CloudFile cloud = geometry::ReadCloud(file);
  if (!cloud.sensor_origin) {
    throw base::InputError(file.string() + ": has no VIEWPOINT: where the laser stood");
  }
  view.laser_origin_W = *cloud.sensor_origin;
  for (const Eigen::Vector3d& p : cloud.points) {
    if (p.allFinite()) view.laser_W.push_back(p);
  }
  return view;
}

CalibrationResult CalibrateRecorded(const std::filesystem::path& folder,
                                    const ChessboardOptions& board) {
  std::vector<BoardSighting> boards;
  int width = 0, height = 0;
  for (int number = 1; std::filesystem::exists(FileOf(folder, "left", number, "png")); ++number) {
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
                           ": holds no left_01.png, right_01.png, board_01.pcd and so on");
  }
  return CalibrateStereo(boards, width, height, board);
}

CalibrationSetup SimulatedSetup(const CalibrateArguments& arguments) {
  CalibrationSetup setup;
  const std::filesystem::path source = arguments.source;
  if (source.extension() != ".yaml" && source.extension() != ".yml") {
    setup.scene = source;
    return setup;
  }
  const auto opened = experiment::OpenExperiment(source, experiment::AllKinds(), {});
  const trial::Cell& cell = trial::CellOf(*opened.task);
  const auto camera = CameraFileOf(cell.options);
  if (camera.empty()) throw base::InputError(source.string() + ": its sensor is no stereo camera");
  setup.scene = cell.options.scene;
  setup.scanner = cell.scanner;
  setup.camera = sensing::ReadStereoCamera(camera);
  return setup;
}

CalibrationResult CalibrateInSimulation(const CalibrateArguments& arguments,
                                        const ChessboardOptions& board) {
  CalibrationSetup setup = SimulatedSetup(arguments);
  setup.views = arguments.views;
  setup.seed = arguments.seed;
  int number = 0;
  return CalibrateSimulated(setup, board, [&](const BoardView& view) {
    ++number;
    if (!arguments.record.empty()) Write(view, arguments.record, number);
  });
}

void Calibrate(const CalibrateArguments& arguments) {
  const ChessboardOptions board = BoardOf(arguments.board);
  const CalibrationResult result = std::filesystem::is_directory(arguments.source)
                                       ? CalibrateRecorded(arguments.source, board)
                                       : CalibrateInSimulation(arguments, board);
  WriteStereoCalibration(result.calibration, arguments.out);
  spdlog::info(
      "{} views: corners {:.3f} px off the camera and {:.3f} px off the pair; as one camera sees "
      "them {:.2f} mm off the laser's planes, triangulated {:.2f} mm (rms); squares of {:.2f} +- "
      "{:.2f} mm would fit best",
      result.views, result.camera_px, result.stereo_px, result.registration_m * base::kMmPerM,
      result.triangulated_m * base::kMmPerM, result.scale * board.square_m * base::kMmPerM,
      result.scale_error * board.square_m * base::kMmPerM);
}

void AddCalibrateStereoCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "calibrate-stereo",
      "Lens and places of the stereo camera from a chessboard that the laser scanned, too.");
  auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("source", arguments->source,
                   "folder with left_01.png, right_01.png, board_01.pcd and so on; or a scene "
                   "(MJCF) or experiment (YAML), in which a chessboard is simulated")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("-o,--out", arguments->out, "calibration (YAML)")->required();
  AddBoardOptions(*command, arguments->board);
  command->add_option("--views", arguments->views, "simulated places of the board (16)")
      ->check(CLI::Range(1, 200));
  command->add_option("--seed", arguments->seed, "of the simulation (1)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--record", arguments->record,
                      "folder for the simulated pictures and clouds");
  command->footer(
      "Example: rangegrasp calibrate-stereo scenes/tabletop.xml -o stereo.yaml --record boards\n"
      "A board's cloud holds the laser's points of it in the arm's frame; its VIEWPOINT is where "
      "the laser stood.");
  command->callback([arguments] { Calibrate(*arguments); });
}

constexpr char kRecord[] = "views.yaml";
/// An arm that repeats to 0.02 deg moves the pictures of a lens of 800 px by 0.3 px.
constexpr double kMaxReprojection_px = 1.0;

struct HandEyeArguments {
  std::string source, out, record, camera;
  ChessboardArgument board;
  int views = HandEyeSetup{}.views;
  std::uint64_t seed = 1;
};

std::filesystem::path PictureFile(const std::filesystem::path& folder, std::size_t number) {
  return folder / fmt::format("view_{:02}.png", number);
}

/// All inputs of the calibration.
struct Recorded {
  HandEyeRecord record;
  std::vector<image::Image> pictures;
};

Recorded Read(const std::filesystem::path& folder) {
  Recorded recorded{ReadHandEyeRecord(folder / kRecord), {}};
  const Camera& camera = recorded.record.camera;
  for (std::size_t i = 1; i <= recorded.record.X_WH.size(); ++i) {
    const auto file = PictureFile(folder, i);
    recorded.pictures.push_back(image::ReadPng<image::Image>(file));
    const image::Image& picture = recorded.pictures.back();
    if (picture.width != camera.width || picture.height != camera.height) {
      throw base::InputError(fmt::format("{}: has {} x {} pixels, the camera of {} has {} x {}",
                                         file.string(), picture.width, picture.height, kRecord,
                                         camera.width, camera.height));
    }
  }
  return recorded;
}

void Write(const Recorded& recorded, const std::filesystem::path& folder) {
  WriteHandEyeRecord(recorded.record, folder / kRecord);
  for (std::size_t i = 0; i < recorded.pictures.size(); ++i) {
    image::WritePng(PictureFile(folder, i + 1), recorded.pictures[i]);
  }
}

bool ShowsBoard(const image::Image& picture, const ChessboardOptions& board) {
  try {
    FindBoardCorners(picture, "a view", board);
    return true;
  } catch (const base::InputError&) {
    return false;
  }
}

HandEyeResult Solve(const Recorded& recorded, const ChessboardOptions& board) {
  std::vector<HandEyeView> views;
  for (std::size_t i = 0; i < recorded.pictures.size(); ++i) {
    const std::string name = PictureFile("", i + 1).string();
    views.push_back({recorded.record.X_WH[i], FindBoardCorners(recorded.pictures[i], name, board)});
  }
  return CalibrateHandEye(views, recorded.record.camera, board);
}

void Report(const HandEyeResult& result, std::size_t views) {
  spdlog::info(
      "{} views: corners {:.3f} px off, the board {:.2f} mm (rms); the head's place is known to "
      "{:.2f} mm and {:.3f} deg (standard errors)",
      views, result.rms_px, result.rms_m * base::kMmPerM, result.shift_error_m * base::kMmPerM,
      result.turn_error_rad / base::kDeg);
}

void ReportTruth(const base::Pose& X_HS, const base::Pose& X_HSTrue) {
  const base::Pose apart = X_HSTrue.inverse() * X_HS;
  spdlog::info("in the simulation the head is {:.2f} mm and {:.3f} deg from there",
               apart.translation().norm() * base::kMmPerM,
               Eigen::AngleAxisd(apart.linear()).angle() / base::kDeg);
}

void Calibrate(const HandEyeArguments& arguments) {
  ChessboardOptions board = BoardOf(arguments.board);
  board.max_reprojection_px = kMaxReprojection_px;
  Recorded recorded;
  std::optional<base::Pose> X_HSTrue;
  if (std::filesystem::is_directory(arguments.source)) {
    recorded = Read(arguments.source);
  } else {
    HandEyeSetup setup;
    setup.scene = arguments.source;
    setup.camera = sensing::ReadStereoCamera(
        arguments.camera.empty() ? base::DataFolder() / "models/sensors/wrist_camera.yaml"
                                 : std::filesystem::path(arguments.camera));
    setup.views = arguments.views;
    setup.seed = arguments.seed;
    auto run = SimulateHandEye(
        setup, [&](const image::Image& picture) { return ShowsBoard(picture, board); });
    X_HSTrue = run.X_HS;
    recorded = {std::move(run.record), std::move(run.pictures)};
    if (!arguments.record.empty()) Write(recorded, arguments.record);
  }
  const HandEyeResult result = Solve(recorded, board);
  const base::Pose X_HS = result.X_HC * recorded.record.X_SC.inverse();
  sensing::WriteHandEye({X_HS, result.shift_error_m, result.turn_error_rad}, arguments.out);
  Report(result, recorded.pictures.size());
  if (X_HSTrue) ReportTruth(X_HS, *X_HSTrue);
}

void AddCalibrateHandEyeCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "calibrate-hand-eye",
      "Where the sensor on the arm's flange sits, from a chessboard on the table.");
  auto arguments = std::make_shared<HandEyeArguments>();
  command
      ->add_option("source", arguments->source,
                   "folder with views.yaml and view_01.png and so on; or a scene (MJCF) in which "
                   "the arm is simulated")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("-o,--out", arguments->out, "calibration (YAML), for look.hand_eye")
      ->required();
  AddBoardOptions(*command, arguments->board);
  command
      ->add_option("--camera", arguments->camera,
                   "of the simulation (models/sensors/wrist_camera.yaml)")
      ->check(CLI::ExistingFile);
  command->add_option("--views", arguments->views, "simulated pictures (25)")
      ->check(CLI::Range(1, 99));
  command->add_option("--seed", arguments->seed, "of the simulation (1)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--record", arguments->record, "folder for the simulated pictures and poses");
  command->footer(
      "Example: rangegrasp calibrate-hand-eye scenes/tabletop_wrist.xml -o hand_eye.yaml --record "
      "boards\n"
      "views.yaml holds the lens (camera), the camera's place in its head (in_head) and the hand's "
      "pose in the arm's frame at each picture (view_01 ...).");
  command->callback([arguments] { Calibrate(*arguments); });
}

}  // namespace
}  // namespace rangegrasp::stereo

namespace rangegrasp {

void RegisterStereo() {
  namespace fs = std::filesystem;
  trial::AddSensor({.word = stereo::kStereoCamera,
                    .states_noise = true,
                    .laser = [](const fs::path&) { return fs::path(); },
                    .files = [](const fs::path&) { return std::vector<fs::path>(); },
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
                          trial::MakeLineScanner(cell.scanner, cell.robot.X_WScanner),
                          stereo::StereoOf(cell, stereo::ReadBoth(cell.options.sensor).stereo));
                    }});
  trial::AddKeyReader(stereo::ReadKeys);
  cli::AddLibrary("opencv", RANGEGRASP_OPENCV_VERSION);
  cli::AddCommand(stereo::AddStereoCommand);
  cli::AddCommand(stereo::AddCalibrateHandEyeCommand);
  cli::AddCommand(stereo::AddCalibrateStereoCommand);
}

}  // namespace rangegrasp
