#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>

#include "base/data_folder.h"
#include "base/error.h"
#include "base/image/png.h"
#include "base/stopwatch.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "geometry/cloud_file.h"
#include "geometry/draw/canvas.h"
#include "sensing/line_scanner.h"
#include "sensing/surface_state.h"
#include "sim/check_object.h"
#include "sim/object_picture.h"
#include "sim/render.h"
#include "trial/attempt.h"
#include "trial/cloud_fields.h"
#include "trial/command/grasping_commands.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"

namespace rangegrasp::cli {
namespace {

bool IsExperiment(const std::filesystem::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

// The settled world of an experiment's trial, or a scene file as it stands.
struct Picked {
  std::unique_ptr<sim::World> world;
  experiment::Experiment experiment;  // empty for a scene
  trial::TrialSpec spec;
  std::uint64_t seed = 1;

  const trial::Cell& cell() const { return trial::CellOf(*experiment.task); }
};

Picked PickScene(const std::filesystem::path& file, std::optional<std::uint64_t> seed) {
  Picked picked;
  picked.world =
      std::make_unique<sim::World>(file, std::vector<sim::ObjectModel>{}, sim::PhysicsOptions{});
  picked.world->SetArm(robot::Robot::Load(file).home);
  picked.world->Settle();
  picked.seed = seed.value_or(picked.seed);
  return picked;
}

// A sensor's file, or one of the installed ones by its word.
std::filesystem::path SensorFile(const std::string& sensor) {
  if (sensor == "laser") return base::DataFolder() / "models/sensors/line_scanner.yaml";
  if (sensor == "stereo") return base::DataFolder() / "models/sensors/stereo_camera.yaml";
  return std::filesystem::absolute(sensor);
}

Picked PickTrial(const std::filesystem::path& file, const std::string& trial,
                 std::optional<std::uint64_t> seed, const std::string& sensor) {
  Picked picked;
  experiment::Changes changes;
  changes.seed = seed;
  if (!sensor.empty()) changes.set.push_back("sensor=" + SensorFile(sensor).string());
  picked.experiment = experiment::OpenExperiment(file, experiment::AllKinds(), changes);
  const trial::Cell& cell = picked.cell();
  cell.sensor->Prepare();  // before the world is there, whose engine starts threads
  picked.spec = trial::SpecOf(trial.empty() ? picked.experiment.cases.front()
                                            : CaseOf(picked.experiment, trial));
  picked.seed = picked.spec.seed;
  auto arranged = ArrangeTrial(cell, picked.spec);
  if (!arranged) {
    throw base::RunError(file.string() + ": no arrangement of " + TrialId(picked.spec) +
                         " came to rest in view");
  }
  picked.world = std::make_unique<sim::World>(std::move(arranged->world));
  return picked;
}

Picked Pick(const std::filesystem::path& file, const std::string& trial,
            std::optional<std::uint64_t> seed, const std::string& sensor = "") {
  if (IsExperiment(file)) return PickTrial(file, trial, seed, sensor);
  if (!trial.empty()) {
    throw base::InputError("--trial goes with an experiment file, not with " + file.string());
  }
  return PickScene(file, seed);
}

void AddSnapshot(CLI::App& app) {
  struct Arguments {
    std::string file, out, trial, camera, size = "1280x960";
    std::optional<std::uint64_t> seed;
  };
  auto* command = app.add_subcommand(
      "snapshot",
      "Picture of a scene, of an object, or of an experiment's trial at its start, as PNG.");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("file", arguments->file, "scene or object (MJCF) or experiment (YAML)")
      ->required();
  command->add_option("-o,--out", arguments->out, "PNG file")->required();
  command->add_option("--camera", arguments->camera,
                      "camera of the scene, or a free view x,y,z,lookx,looky,lookz [m] (default: "
                      "overview; near by of an object)");
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels");
  command->add_option("--trial", arguments->trial, "of the experiment (default: its first)");
  command->add_option("--seed", arguments->seed, "instead of the experiment's")
      ->check(CLI::NonNegativeNumber);
  command->footer(
      "Example: rangegrasp snapshot scenes/tabletop.xml -o table.png --camera overview");
  command->callback([arguments] {
    CheckEnding(arguments->out, {".png"});
    const auto [width, height] = ParseSize(arguments->size);
    if (!IsExperiment(arguments->file) && sim::IsObjectFile(arguments->file)) {
      const std::filesystem::path file = arguments->file;
      image::WritePng(arguments->out, sim::DrawObject({file.stem().string(), file},
                                                      arguments->camera, width, height));
      return;
    }
    Picked picked = Pick(arguments->file, arguments->trial, arguments->seed);
    const std::string camera = arguments->camera.empty() ? "overview" : arguments->camera;
    image::WritePng(arguments->out,
                    sim::Renderer(*picked.world, width, height).Render(*picked.world, camera));
  });
}

/// The image with nothing measured but the target.
geometry::RangeImage TargetOnly(const sensing::Scan& scan) {
  geometry::RangeImage image = scan.view.image;
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    if (scan.truth.label[i] != 1) {
      image.points_C[i].setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return image;
}

/// The scan, objects and table apart, and the shadows on the table plane round the workspace.
image::Image DrawScan(const sensing::Scan& scan, const std::vector<sim::VisualMesh>& meshes,
                      const base::Pose& X_WS, const sensing::LineScannerOptions& options) {
  constexpr double kHalf_m = 0.30;
  constexpr double kStep_m = 0.0015;
  geometry::Points grid;
  for (double x = -kHalf_m; x <= kHalf_m; x += kStep_m) {
    for (double y = -kHalf_m; y <= kHalf_m; y += kStep_m)
      grid.emplace_back(x, y, 0.001);  // above what is painted on the table
  }
  const auto states = sensing::ClassifySurface(grid, meshes, X_WS, options);
  draw::Canvas canvas;
  const auto add = [&](sensing::SurfaceState state, const draw::Color& color) {
    geometry::Points chosen;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (states[i] == state) chosen.push_back(grid[i]);
    }
    canvas.dots.push_back({std::move(chosen), color, 3.0F});
  };
  add(sensing::SurfaceState::kLaserShadow, {0.90F, 0.25F, 0.20F, 1.0F});
  add(sensing::SurfaceState::kCameraShadow, {0.95F, 0.75F, 0.15F, 1.0F});
  add(sensing::SurfaceState::kBothShadows, {0.35F, 0.15F, 0.15F, 1.0F});
  geometry::Points scene, target;
  for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p = scan.view.image.points_C[i];
    if (!p.allFinite() || p.head<2>().norm() > 1.5 * kHalf_m) continue;
    (scan.truth.label[i] == 0 ? scene : target).push_back(p);
  }
  canvas.dots.push_back({std::move(scene), {0.45F, 0.58F, 0.80F, 1.0F}, 1.5F});
  canvas.dots.push_back({std::move(target), {0.10F, 0.45F, 0.20F, 1.0F}, 2.5F});
  const draw::View view{{0.75, -0.35, 0.75}, {-0.02, 0.0, 0.0}, Eigen::Vector3d::UnitZ(), 0.55};
  return draw::Render(canvas, view, 1280, 960);
}

struct ScanArguments {
  std::string file, out, trial, sensor, picture;
  std::optional<std::uint64_t> seed;
  bool target_only = false;
};

// The sensor writes the cloud itself, with what lies between. @return whether it does that
bool WriteItsLook(const Picked& picked, const ScanArguments& arguments) {
  if (!picked.experiment.task || picked.cell().options.sensor_type == trial::kLineScanner) {
    return false;
  }
  base::Rng rng = trial::StageStream(picked.seed, "scan");
  const std::string written = picked.cell().sensor->WriteLook(*picked.world, rng, arguments.out);
  if (written.empty()) return false;
  if (arguments.target_only || !arguments.picture.empty()) {
    throw base::InputError("--picture and --target-only go with a line scanner");
  }
  spdlog::info(written);
  return true;
}

void AddScan(CLI::App& app) {
  auto* command = app.add_subcommand(
      "scan", "One simulated scan as an organised PCD or PLY cloud with labels.");
  auto arguments = std::make_shared<ScanArguments>();
  command->add_option("file", arguments->file, "experiment (YAML) or scene (MJCF)")->required();
  command->add_option("-o,--out", arguments->out, "cloud, .pcd or .ply")->required();
  command->add_option("--trial", arguments->trial, "of the experiment (default: its first)");
  command->add_option("--seed", arguments->seed, "instead of the experiment's")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--picture", arguments->picture, "PNG of the cloud and both shadows");
  command->add_option(
      "--sensor", arguments->sensor,
      "in place of the experiment's: laser, stereo, or a file (YAML); for a scene a line "
      "scanner's file");
  command->add_flag("--target-only", arguments->target_only,
                    "of an experiment: only the target's points, as for rangegrasp parts");
  command->footer(
      "Example: rangegrasp scan experiments/laser_single.yaml --trial coffee_cup-0000 -o mug.pcd\n"
      "Fields: x y z [m], label (0 scene, 1 target, 2 and up other objects, 1000 an open box), "
      "state (0 measured, 1 camera shadow, 2 "
      "dropout, "
      "3 out of view), and rgb with `color: true`.\n--picture draws the shadows that the objects "
      "throw on the table: laser "
      "red, "
      "camera yellow, both dark.\nOf a stereo camera, a folder beside the cloud holds left.png, "
      "right.png, rectified.png, "
      "disparity.png, disparity16.png and calibration.yaml, as rangegrasp stereo takes them.");
  command->callback([arguments] {
    CheckEnding(arguments->out, {".pcd", ".ply"});
    if (!arguments->picture.empty()) CheckEnding(arguments->picture, {".png"});
    Picked picked = Pick(arguments->file, arguments->trial, arguments->seed, arguments->sensor);
    if (WriteItsLook(picked, *arguments)) return;
    const auto options = picked.experiment.task ? picked.cell().scanner
                         : arguments->sensor.empty()
                             ? sensing::LineScannerOptions{}
                             : sensing::ReadLineScanner(SensorFile(arguments->sensor));
    if (arguments->target_only && !picked.experiment.task) {
      throw base::InputError("--target-only: a scene has no target; give an experiment");
    }
    const auto meshes = picked.world->VisualMeshes();
    const base::Pose X_WS = picked.world->SitePose("scanner");
    base::Rng rng(base::DeriveSeed(picked.seed, "scan"));
    base::Stopwatch watch;
    const sensing::Scan scan = sensing::ScanScene(meshes, X_WS, options, rng);
    const double seconds = watch.Seconds();
    geometry::WriteCloud(arguments->out,
                         arguments->target_only ? TargetOnly(scan) : scan.view.image,
                         trial::TruthFields(scan.view, scan.truth));
    if (!arguments->picture.empty()) {
      image::WritePng(arguments->picture, DrawScan(scan, meshes, X_WS, options));
    }
    const auto measured = std::count(scan.truth.state.begin(), scan.truth.state.end(),
                                     sensing::SampleState::kMeasured);
    spdlog::info("{} points in {} profiles of {} samples, {:.0f} ms", measured,
                 scan.view.image.profiles, scan.view.image.samples, seconds * 1e3);
  });
}

}  // namespace

void AddPictureCommands(CLI::App& app) {
  AddSnapshot(app);
  AddScan(app);
}

}  // namespace rangegrasp::cli
