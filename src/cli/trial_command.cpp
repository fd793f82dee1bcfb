#include <spdlog/spdlog.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/output.h"
#include "core/error.h"
#include "draw/scene_view.h"
#include "experiment/runner.h"
#include "sim/render.h"

namespace rangegrasp::cli {
namespace {

using experiment::Experiment;
using experiment::Store;

constexpr int kWidth = 960;
constexpr int kHeight = 720;

struct TrialArguments {
  std::string folder, id, video;
  std::string camera = "close";
  bool snapshots = false;
};

// The experiment as it was run: its file, with what the command line had changed.
Experiment ExperimentOf(const std::map<std::string, std::string>& stamp,
                        const std::string& folder) {
  for (const char* key : {"experiment_file", "experiment_hash", "seed", "trials_per_object"}) {
    if (!stamp.contains(key)) {
      throw core::InputError(folder + ": the results have no stamp '" + key +
                             "' (a run that was killed at its start?); run it again");
    }
  }
  Experiment e = experiment::ReadExperiment(stamp.at("experiment_file"));
  e.seed = std::stoull(stamp.at("seed"));
  e.trials_per_object = std::stoi(stamp.at("trials_per_object"));
  for (const auto& [key, now] : {std::pair{"experiment_hash", experiment::ExperimentHash(e)}}) {
    if (stamp.at(key) != now)
      spdlog::warn("the {} has changed since the run: results may differ", key);
  }
  return e;
}

// Feeds raw frames to ffmpeg where it is installed.
class Video {
 public:
  Video(const std::string& file, int width, int height) : file_(file) {
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0) {
      throw core::InputError(
          "--video needs the program ffmpeg, which is not installed (Debian package ffmpeg)");
    }
    const std::string command = "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s " +
                                std::to_string(width) + "x" + std::to_string(height) +
                                " -r 25 -i - -pix_fmt yuv420p '" + file + "'";
    pipe_ = popen(command.c_str(), "w");
    if (!pipe_) throw core::RunError(file + ": ffmpeg could not be started");
  }
  ~Video() {
    if (pipe_) pclose(pipe_);
  }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  void Add(const sim::Image& image) {
    if (std::fwrite(image.rgb.data(), 1, image.rgb.size(), pipe_) != image.rgb.size()) {
      throw core::RunError(file_ + ": ffmpeg stopped taking frames");
    }
  }
  void Finish() {
    const int status = pclose(pipe_);
    pipe_ = nullptr;
    if (status != 0) throw core::RunError(file_ + ": ffmpeg failed");
  }

 private:
  std::string file_;
  FILE* pipe_ = nullptr;
};

void WarnIfDifferent(const Store& store, experiment::TrialResult result) {
  for (auto stored : store.ReadAll()) {
    if (stored.id != result.id) continue;
    stored.seconds.clear();
    result.seconds.clear();
    if (experiment::ToJson(stored) != experiment::ToJson(result)) {
      spdlog::warn(
          "the replay differs from the stored result: was the program or a model changed since?");
    }
  }
}

void RunTrialCommand(const TrialArguments& arguments) {
  const Store store = Store::Open(arguments.folder);
  const Experiment e = ExperimentOf(store.ReadStamp(), arguments.folder);
  const auto spec = experiment::TrialFrom(e, arguments.id);
  const auto context = experiment::Prepare(e);
  const auto folder = std::filesystem::path(arguments.folder) / "snapshots";
  std::unique_ptr<sim::Renderer> renderer;
  std::unique_ptr<Video> video;
  if (!arguments.video.empty()) video = std::make_unique<Video>(arguments.video, kWidth, kHeight);

  experiment::TrialObserver observer;
  const auto picture = [&](sim::World& world) {
    if (!renderer) renderer = std::make_unique<sim::Renderer>(world, kWidth, kHeight);
    return renderer->Render(world, arguments.camera);
  };
  if (arguments.snapshots) {
    observer.on_perceived = [&](const auto& scene, const auto& grasps, const auto& scan) {
      const auto file = folder / (arguments.id + "_perceived.png");
      MakeFolderOf(file);
      const auto cloud = geometry::ToCloud(scan.image);
      const auto canvas = draw::DrawScene(cloud.points, scene, {grasps}, context.robot.hand());
      const auto view = draw::LookAtScene(scene, scan.image.origins_C.front());
      sim::WritePng(file.string(), draw::Render(canvas, view, kWidth, kHeight));
    };
  }
  if (arguments.snapshots || video) {
    observer.execution.frame_period_s = video ? 0.04 : 0.0;
    observer.execution.on_moment = [&](const std::string& moment, sim::World& world) {
      if (moment == "frame") {
        if (video) video->Add(picture(world));
      } else if (arguments.snapshots) {
        const auto file = folder / (arguments.id + "_" + moment + ".png");
        MakeFolderOf(file);
        sim::WritePng(file.string(), picture(world));
      }
    };
  }
  const auto result = experiment::RunTrial(context, spec, observer);
  if (video) video->Finish();
  WriteResult(experiment::ToJson(result) + "\n");
  WarnIfDifferent(store, result);
  if (arguments.snapshots) spdlog::info("pictures in {}", folder.string());
}

}  // namespace

void AddTrialCommand(CLI::App& app) {
  auto* command = app.add_subcommand(
      "trial", "Replay one trial of a run by its id and print its result as JSON.");
  auto arguments = std::make_shared<TrialArguments>();
  command->add_option("folder", arguments->folder, "results folder")->required();
  command->add_option("id", arguments->id, "trial, e.g. coffee_cup-0003")->required();
  command->add_flag("--snapshots", arguments->snapshots,
                    "pictures of every stage into <folder>/snapshots");
  command->add_option("--video", arguments->video,
                      "film of the execution, 25 frames a second (needs ffmpeg)");
  command->add_option("--camera", arguments->camera, "camera of the scene");
  command->footer("Example: rangegrasp trial results/laser_single coffee_cup-0003 --snapshots");
  command->callback([arguments] { RunTrialCommand(*arguments); });
}

}  // namespace rangegrasp::cli
