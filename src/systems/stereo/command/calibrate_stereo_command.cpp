#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/image/png.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "geometry/cloud_file.h"
#include "stereo/command/chessboard_argument.h"
#include "stereo/command/stereo_commands.h"
#include "stereo/pictures.h"
#include "stereo/sensing/chessboard_recorder.h"
#include "stereo/sensing/stereo_calibration.h"
#include "stereo/sensing/stereo_of_cell.h"
#include "trial/grasping_task.h"

namespace rangegrasp::cli {
namespace {

struct CalibrateArguments {
  std::string source, out, record;
  ChessboardArgument board;
  int views = trial::CalibrationSetup{}.views;
  std::uint64_t seed = 1;
};

std::filesystem::path FileOf(const std::filesystem::path& folder, const char* what, int number,
                             const char* ending) {
  return folder / fmt::format("{}_{:02}.{}", what, number, ending);
}

void Write(const stereo::BoardView& view, const std::filesystem::path& folder, int number) {
  image::WritePng(FileOf(folder, "left", number, "png"), view.left);
  image::WritePng(FileOf(folder, "right", number, "png"), view.right);
  geometry::RangeImage board;
  board.profiles = 1;
  board.samples = static_cast<int>(view.laser_W.size());
  board.points_C = view.laser_W;
  board.origins_C = {view.laser_origin_W};
  geometry::WriteCloud(FileOf(folder, "board", number, "pcd"), board);
}

stereo::BoardView ReadView(const std::filesystem::path& folder, int number) {
  stereo::BoardView view;
  view.name = fmt::format("view {}", number);
  stereo::PicturePair pair = stereo::ReadPicturePair(FileOf(folder, "left", number, "png"),
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

stereo::CalibrationResult CalibrateRecorded(const std::filesystem::path& folder,
                                            const stereo::ChessboardOptions& board) {
  std::vector<stereo::BoardSighting> boards;
  int width = 0, height = 0;
  for (int number = 1; std::filesystem::exists(FileOf(folder, "left", number, "png")); ++number) {
    const stereo::BoardView view = ReadView(folder, number);
    if (number > 1 && (view.left.width != width || view.left.height != height)) {
      throw base::InputError(fmt::format("{}: {} has {} x {} pixels, the first has {} x {}",
                                         folder.string(), view.name, view.left.width,
                                         view.left.height, width, height));
    }
    width = view.left.width;
    height = view.left.height;
    boards.push_back(stereo::FindBoard(view, board));
  }
  if (boards.empty()) {
    throw base::InputError(folder.string() +
                           ": holds no left_01.png, right_01.png, board_01.pcd and so on");
  }
  return stereo::CalibrateStereo(boards, width, height, board);
}

trial::CalibrationSetup SimulatedSetup(const CalibrateArguments& arguments) {
  trial::CalibrationSetup setup;
  const std::filesystem::path source = arguments.source;
  if (source.extension() != ".yaml" && source.extension() != ".yml") {
    setup.scene = source;
    return setup;
  }
  const auto opened = experiment::OpenExperiment(source, experiment::AllKinds(), {});
  const trial::Cell& cell = trial::CellOf(*opened.task);
  const auto camera = stereo::CameraFileOf(cell.options);
  if (camera.empty()) throw base::InputError(source.string() + ": its sensor is no stereo camera");
  setup.scene = cell.options.scene;
  setup.scanner = cell.scanner;
  setup.camera = sensing::ReadStereoCamera(camera);
  return setup;
}

stereo::CalibrationResult CalibrateInSimulation(const CalibrateArguments& arguments,
                                                const stereo::ChessboardOptions& board) {
  const trial::CalibrationSetup setup = SimulatedSetup(arguments);
  sensing::ChessboardRecorder recorder(setup.scene, trial::ChessboardModel(), setup.camera,
                                       setup.scanner, {}, arguments.seed);
  int number = 0;
  return sensing::CalibrateSimulated(recorder, arguments.views, setup.camera, board,
                                     [&](const stereo::BoardView& view) {
                                       ++number;
                                       if (!arguments.record.empty())
                                         Write(view, arguments.record, number);
                                     });
}

void Calibrate(const CalibrateArguments& arguments) {
  const stereo::ChessboardOptions board = BoardOf(arguments.board);
  const stereo::CalibrationResult result = std::filesystem::is_directory(arguments.source)
                                               ? CalibrateRecorded(arguments.source, board)
                                               : CalibrateInSimulation(arguments, board);
  stereo::WriteStereoCalibration(result.calibration, arguments.out);
  spdlog::info(
      "{} views: corners {:.3f} px off the camera and {:.3f} px off the pair; as one camera sees "
      "them {:.2f} mm off the laser's planes, triangulated {:.2f} mm (rms); squares of {:.2f} +- "
      "{:.2f} mm would fit best",
      result.views, result.camera_px, result.stereo_px, result.registration_m * base::kMmPerM,
      result.triangulated_m * base::kMmPerM, result.scale * board.square_m * base::kMmPerM,
      result.scale_error * board.square_m * base::kMmPerM);
}

}  // namespace

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

}  // namespace rangegrasp::cli
