#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/error.h"
#include "core/stopwatch.h"
#include "experiment/trial.h"
#include "geometry/io.h"
#include "sim/render.h"

namespace rangegrasp::cli {
namespace {

bool IsExperiment(const std::filesystem::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

// The settled world of an experiment's trial, or a scene file as it stands.
struct Picked {
  std::unique_ptr<sim::World> world;
  std::optional<experiment::TrialContext> context;
  std::uint64_t seed = 0;
};

Picked Pick(const std::filesystem::path& file, const std::string& trial,
            std::optional<std::uint64_t> seed) {
  Picked picked;
  if (!IsExperiment(file)) {
    if (!trial.empty())
      throw core::InputError("--trial goes with an experiment file, not with " + file.string());
    picked.world =
        std::make_unique<sim::World>(file, std::vector<sim::ObjectModel>{}, sim::PhysicsOptions{});
    picked.world->SetArm(robot::Robot::Load(file).home);
    picked.world->Settle();
    picked.seed = seed.value_or(1);
    return picked;
  }
  auto e = experiment::ReadExperiment(file);
  if (seed) e.seed = *seed;
  const auto spec =
      trial.empty() ? experiment::AllTrials(e).front() : experiment::TrialFrom(e, trial);
  picked.context = experiment::Prepare(e);
  picked.seed = experiment::TrialSeed(e.seed, spec);
  auto arranged = experiment::Arrange(*picked.context, spec, picked.seed);
  if (!arranged)
    throw core::RunError(file.string() + ": no arrangement of " + experiment::TrialId(spec) +
                         " came to rest in view");
  picked.world = std::make_unique<sim::World>(std::move(arranged->world));
  return picked;
}

void AddSnapshot(CLI::App& app) {
  struct Arguments {
    std::string file, out, trial, camera = "overview", size = "1280x960";
    std::optional<std::uint64_t> seed;
  };
  auto* command = app.add_subcommand(
      "snapshot", "Picture of a scene, or of an experiment's trial at its start, as PNG.");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("file", arguments->file, "scene (MJCF) or experiment (YAML)")->required();
  command->add_option("-o,--out", arguments->out, "PNG file")->required();
  command->add_option("--camera", arguments->camera, "camera of the scene");
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels");
  command->add_option("--trial", arguments->trial, "of the experiment (default: its first)");
  command->add_option("--seed", arguments->seed, "instead of the experiment's")
      ->check(CLI::NonNegativeNumber);
  command->footer(
      "Example: rangegrasp snapshot scenes/tabletop.xml -o table.png --camera overview");
  command->callback([arguments] {
    const auto [width, height] = ParseSize(arguments->size);
    Picked picked = Pick(arguments->file, arguments->trial, arguments->seed);
    MakeFolderOf(arguments->out);
    sim::WritePng(
        arguments->out,
        sim::Renderer(*picked.world, width, height).Render(*picked.world, arguments->camera));
  });
}

// What a label or state file holds, beside the cloud.
std::vector<geometry::CloudField> TruthFields(const sensing::ScanTruth& truth) {
  geometry::CloudField label{"label", truth.label};
  geometry::CloudField state{"state", {}};
  for (const auto s : truth.state) state.values.push_back(static_cast<std::uint32_t>(s));
  return {label, state};
}

void AddScan(CLI::App& app) {
  struct Arguments {
    std::string file, out, trial, sensor;
    std::optional<std::uint64_t> seed;
  };
  auto* command = app.add_subcommand(
      "scan", "One simulated scan as an organised PCD or PLY cloud with labels.");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("file", arguments->file, "experiment (YAML) or scene (MJCF)")->required();
  command->add_option("-o,--out", arguments->out, "cloud, .pcd or .ply")->required();
  command->add_option("--trial", arguments->trial, "of the experiment (default: its first)");
  command->add_option("--seed", arguments->seed, "instead of the experiment's")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--sensor", arguments->sensor, "sensor file (YAML) for a scene");
  command->footer(
      "Example: rangegrasp scan experiments/laser_single.yaml --trial coffee_cup-0000 -o mug.pcd\n"
      "Fields: x y z [m], label (0 scene, 1 target), state (0 measured, 1 laser shadow, 2 camera "
      "shadow, 3 dropout, 4 out of view).");
  command->callback([arguments] {
    Picked picked = Pick(arguments->file, arguments->trial, arguments->seed);
    sensing::Scan scan;
    core::Stopwatch watch;
    if (picked.context) {
      scan = experiment::ScanWorld(*picked.context, *picked.world, picked.seed);
    } else {
      const auto options = arguments->sensor.empty() ? sensing::LineScannerOptions{}
                                                     : sensing::ReadLineScanner(arguments->sensor);
      core::Rng rng(core::DeriveSeed(picked.seed, "scan"));
      scan = sensing::ScanScene(picked.world->VisualMeshes(), picked.world->SitePose("scanner"),
                                options, rng);
    }
    const double seconds = watch.Seconds();
    MakeFolderOf(arguments->out);
    geometry::WriteCloud(arguments->out, scan.image, TruthFields(scan.truth));
    const auto measured = std::count(scan.truth.state.begin(), scan.truth.state.end(),
                                     sensing::SampleState::kMeasured);
    spdlog::info("{} points in {} profiles of {} samples, {:.0f} ms", measured, scan.image.profiles,
                 scan.image.samples, seconds * 1e3);
  });
}

}  // namespace

void AddPictureCommands(CLI::App& app) {
  AddSnapshot(app);
  AddScan(app);
}

}  // namespace rangegrasp::cli
