#include "tasks/grasping/replay.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "core/error.h"
#include "core/file.h"
#include "draw/scene_view.h"
#include "image/png.h"
#include "sim/render.h"

namespace rangegrasp::tasks::grasping {
namespace {

// Of pictures and films [px], and of films [frames/s].
constexpr int kWidth_px = 960;
constexpr int kHeight_px = 720;
constexpr int kFrameRate_hz = 25;
constexpr const char* kCamera = "close";

// Feeds raw frames to ffmpeg where it is installed.
class Video {
 public:
  explicit Video(const std::filesystem::path& file) : file_(file) {
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0) {
      throw core::InputError(
          "--video needs the program ffmpeg, which is not installed (Debian package ffmpeg)");
    }
    core::MakeFolderOf(file);
    const std::string command = fmt::format(
        "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} -i - -pix_fmt yuv420p "
        "'{}'",
        kWidth_px, kHeight_px, kFrameRate_hz, file.string());
    pipe_ = popen(command.c_str(), "w");
    if (!pipe_) throw core::RunError(file.string() + ": ffmpeg could not be started");
  }
  ~Video() {
    if (pipe_) pclose(pipe_);
  }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  void Add(const image::Image& image) {
    if (std::fwrite(image.rgb.data(), 1, image.rgb.size(), pipe_) != image.rgb.size()) {
      throw core::RunError(file_.string() + ": ffmpeg stopped taking frames");
    }
  }
  void Finish() {
    const int status = pclose(pipe_);
    pipe_ = nullptr;
    if (status != 0) throw core::RunError(file_.string() + ": ffmpeg failed");
  }

 private:
  std::filesystem::path file_;
  FILE* pipe_ = nullptr;
};

class Replay {
 public:
  Replay(const Cell& cell, const TrialSpec& spec, const experiment::ReplayOptions& options)
      : cell_(cell), spec_(spec), options_(options) {
    if (!options.video.empty()) video_ = std::make_unique<Video>(options.video);
  }

  experiment::Result Run() {
    const auto detector =
        MakeDetector(cell_.options, cell_.robot, [this](auto&&... all) { OnScene(all...); });
    sim::ExecutionObserver observer;
    if (options_.snapshots || video_) {
      observer.frame_period_s = video_ ? 1.0 / kFrameRate_hz : 0.0;
      observer.on_moment = [this](const std::string& moment, sim::World& world) {
        OnMoment(moment, world);
      };
    }
    const auto result = RunTrial(cell_, spec_, detector.get(), observer);
    if (video_) video_->Finish();
    return result;
  }

 private:
  std::filesystem::path File(const std::string& what) const {
    return options_.folder / fmt::format("{}_{}.png", TrialId(spec_), what);
  }

  void Write(const std::string& what, const image::Image& image) const {
    image::WritePng(File(what), image);
  }

  void OnScene(const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
               const geometry::Observation& observation) const {
    if (!options_.snapshots) return;
    const auto& image = observation.views.front().image;
    const auto canvas =
        draw::DrawScene(geometry::ToCloud(image).points, scene, {grasps}, cell_.robot.hand());
    const auto view = draw::LookAtScene(scene, image.origins_C.front());
    Write("perceived", draw::Render(canvas, view, kWidth_px, kHeight_px));
  }

  void OnMoment(const std::string& moment, sim::World& world) {
    if (moment == "frame" ? !video_ : !options_.snapshots) return;
    if (!renderer_) renderer_ = std::make_unique<sim::Renderer>(world, kWidth_px, kHeight_px);
    const auto image =
        renderer_->Render(world, options_.camera.empty() ? kCamera : options_.camera);
    if (moment == "frame") {
      video_->Add(image);
    } else {
      Write(moment, image);
    }
  }

  const Cell& cell_;
  const TrialSpec& spec_;
  const experiment::ReplayOptions& options_;
  std::unique_ptr<Video> video_;
  std::unique_ptr<sim::Renderer> renderer_;
};

}  // namespace

experiment::Result ReplayTrial(const Cell& cell, const TrialSpec& spec,
                               const experiment::ReplayOptions& options) {
  return Replay(cell, spec, options).Run();
}

}  // namespace rangegrasp::tasks::grasping
