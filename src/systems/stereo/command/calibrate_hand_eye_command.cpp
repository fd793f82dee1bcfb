#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "base/data_folder.h"
#include "base/error.h"
#include "base/image/png.h"
#include "base/units.h"
#include "sensing/hand_eye.h"
#include "stereo/command/chessboard_argument.h"
#include "stereo/command/stereo_commands.h"
#include "stereo/hand_eye.h"
#include "stereo/sensing/hand_eye_calibration.h"

namespace rangegrasp::cli {
namespace {

constexpr char kRecord[] = "views.yaml";
/// An arm that repeats to 0.02 deg moves the pictures of a lens of 800 px by 0.3 px.
constexpr double kMaxReprojection_px = 1.0;

struct HandEyeArguments {
  std::string source, out, record, camera;
  ChessboardArgument board;
  int views = trial::HandEyeSetup{}.views;
  std::uint64_t seed = 1;
};

std::filesystem::path PictureFile(const std::filesystem::path& folder, std::size_t number) {
  return folder / fmt::format("view_{:02}.png", number);
}

/// All that the calibration is told.
struct Recorded {
  stereo::HandEyeRecord record;
  std::vector<image::Image> pictures;
};

Recorded Read(const std::filesystem::path& folder) {
  Recorded recorded{stereo::ReadHandEyeRecord(folder / kRecord), {}};
  const stereo::Camera& camera = recorded.record.camera;
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
  stereo::WriteHandEyeRecord(recorded.record, folder / kRecord);
  for (std::size_t i = 0; i < recorded.pictures.size(); ++i) {
    image::WritePng(PictureFile(folder, i + 1), recorded.pictures[i]);
  }
}

bool ShowsBoard(const image::Image& picture, const stereo::ChessboardOptions& board) {
  try {
    stereo::FindBoardCorners(picture, "a view", board);
    return true;
  } catch (const base::InputError&) {
    return false;
  }
}

stereo::HandEyeResult Solve(const Recorded& recorded, const stereo::ChessboardOptions& board) {
  std::vector<stereo::HandEyeView> views;
  for (std::size_t i = 0; i < recorded.pictures.size(); ++i) {
    const std::string name = PictureFile("", i + 1).string();
    views.push_back(
        {recorded.record.X_WH[i], stereo::FindBoardCorners(recorded.pictures[i], name, board)});
  }
  return stereo::CalibrateHandEye(views, recorded.record.camera, board);
}

void Report(const stereo::HandEyeResult& result, std::size_t views) {
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
  stereo::ChessboardOptions board = BoardOf(arguments.board);
  board.max_reprojection_px = kMaxReprojection_px;
  Recorded recorded;
  std::optional<base::Pose> X_HSTrue;
  if (std::filesystem::is_directory(arguments.source)) {
    recorded = Read(arguments.source);
  } else {
    trial::HandEyeSetup setup;
    setup.scene = arguments.source;
    setup.camera = sensing::ReadStereoCamera(
        arguments.camera.empty() ? base::DataFolder() / "models/sensors/wrist_camera.yaml"
                                 : std::filesystem::path(arguments.camera));
    setup.views = arguments.views;
    setup.seed = arguments.seed;
    auto run = trial::SimulateHandEye(
        setup, [&](const image::Image& picture) { return ShowsBoard(picture, board); });
    X_HSTrue = run.X_HS;
    recorded = {std::move(run.record), std::move(run.pictures)};
    if (!arguments.record.empty()) Write(recorded, arguments.record);
  }
  const stereo::HandEyeResult result = Solve(recorded, board);
  const base::Pose X_HS = result.X_HC * recorded.record.X_SC.inverse();
  sensing::WriteHandEye({X_HS, result.shift_error_m, result.turn_error_rad}, arguments.out);
  Report(result, recorded.pictures.size());
  if (X_HSTrue) ReportTruth(X_HS, *X_HSTrue);
}

}  // namespace

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

}  // namespace rangegrasp::cli
