#include "tasks/grasping/recorder.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

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

}  // namespace

struct Recorder::Impl {
  const Cell& cell;
  experiment::ReplayOptions options;
  std::string prefix;
  std::function<bool(const std::string&)> wanted;
  std::function<void(const std::string&, const image::Image&)> on_picture;
  std::unique_ptr<Video> video;
  std::unique_ptr<sim::Renderer> renderer;
  std::unique_ptr<Detector> detector;

  void Write(const std::string& what, const image::Image& image) const {
    image::WritePng(options.folder / fmt::format("{}_{}.png", prefix, what), image);
    if (on_picture) on_picture(what, image);
  }

  void OnScene(const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
               const geometry::Observation& observation) const {
    if (!options.snapshots) return;
    const auto& image = observation.views.front().image;
    const auto canvas =
        draw::DrawScene(geometry::ToCloud(image).points, scene, {grasps}, cell.robot.hand());
    const auto view = draw::LookAtScene(scene, image.origins_C.front());
    Write("perceived", draw::Render(canvas, view, kWidth_px, kHeight_px));
  }

  void OnMoment(const std::string& moment, sim::World& world) {
    if (moment == "frame" ? !video : !options.snapshots || (wanted && !wanted(moment))) return;
    if (!renderer) renderer = std::make_unique<sim::Renderer>(world, kWidth_px, kHeight_px);
    const auto image = renderer->Render(world, options.camera.empty() ? kCamera : options.camera);
    if (moment == "frame") {
      video->Add(image);
    } else {
      Write(moment, image);
    }
  }
};

Recorder::Recorder(const Cell& cell, const std::string& prefix,
                   const experiment::ReplayOptions& options)
    : impl_(new Impl{cell, options, prefix, {}, {}, nullptr, nullptr, nullptr}) {
  if (!options.video.empty()) impl_->video = std::make_unique<Video>(options.video);
  impl_->detector =
      MakeDetector(cell.options, cell.robot, [this](auto&&... all) { impl_->OnScene(all...); });
}
Recorder::~Recorder() = default;

const Detector& Recorder::detector() const { return *impl_->detector; }

sim::ExecutionObserver Recorder::Observer() {
  sim::ExecutionObserver observer;
  if (!impl_->options.snapshots && !impl_->video) return observer;
  observer.frame_period_s = impl_->video ? 1.0 / kFrameRate_hz : 0.0;
  observer.on_moment = [this](const std::string& moment, sim::World& world) {
    impl_->OnMoment(moment, world);
  };
  return observer;
}

void Recorder::SetPrefix(const std::string& prefix) { impl_->prefix = prefix; }

void Recorder::Take(const std::string& moment, sim::World& world) {
  impl_->OnMoment(moment, world);
}

void Recorder::KeepMoments(std::function<bool(const std::string&)> wanted) {
  impl_->wanted = std::move(wanted);
}

void Recorder::OnPicture(std::function<void(const std::string&, const image::Image&)> on_picture) {
  impl_->on_picture = std::move(on_picture);
}

void Recorder::Finish() {
  if (impl_->video) impl_->video->Finish();
}

}  // namespace rangegrasp::tasks::grasping
