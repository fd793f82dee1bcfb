#include "report/film/internal/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/process/program.h"
#include "base/units.h"
#include "base/words.h"
#include "grasp/scene_view.h"
#include "report/film/internal/sheet.h"
#include "sim/execute.h"
#include "sim/render.h"
#include "trial/registry.h"

namespace rangegrasp::report {
namespace {

namespace fs = std::filesystem;

// Frame rate of films [frames/s].
constexpr int kFrameRate_hz = 25;
// Size of a film's pictures [px]: even, as the encoder requires.
constexpr int kFilmWidth_px = 1280;
constexpr int kFilmHeight_px = 720;
// Width of the scene on the left; the scan is on the right, with the state below it.
constexpr int kFilmScene_px = 800;
constexpr int kRight_px = kFilmWidth_px - kFilmScene_px;
constexpr int kScan_px = kFilmHeight_px / 2;  // height of the scan
// A white band for the title, which would be illegible on a dark arm.
constexpr int kTitleWidth_px = 420;
constexpr int kTitleHeight_px = 36;
// Minimum upper ends of the axes: the shipped hand's first grip, and a visible slip.
constexpr double kForce_N = 20.0;
constexpr double kSlip_mm = 5.0;

const draw::Color kCommand(0.85F, 0.37F, 0.01F, 1.0F);
const draw::Color kFelt(0.12F, 0.47F, 0.71F, 1.0F);
const draw::Color kSlip(0.17F, 0.55F, 0.20F, 1.0F);

// Size of pictures [px], and of those on a sheet.
constexpr int kWidth_px = 960;
constexpr int kHeight_px = 720;
constexpr int kTile_px = 480;
constexpr int kColumns = 3;
// Antialiasing and shadows of a film's many pictures: each takes a tenth of a second.
constexpr sim::RenderQuality kFilmQuality{.samples = 2, .shadow_px = 2048};
// How long a film shows the start of a trial in which nothing moved [s].
constexpr double kStill_s = 2.0;
// ffmpeg encodes a picture in hundredths of a second and ends a film in seconds; else it hangs [s].
constexpr double kLimit_s = 60.0;

fs::path Ffmpeg() {
  if (const auto ffmpeg = process::Find("ffmpeg")) return *ffmpeg;
  throw base::InputError(
      "--video needs the program ffmpeg, which is not installed (Debian package ffmpeg)");
}

// Next to the file, so that it can replace it in one step, with its extension, which ffmpeg needs.
fs::path PartOf(const fs::path& file) {
  auto part = fs::absolute(file);
  part.replace_filename("." + file.stem().string() + ".part" + file.extension().string());
  return part;
}

// A film encoded by ffmpeg, to which pictures are added. The file appears when it is complete; the
// remains of a failed film are removed.
class Video {
 public:
  // @throws base::InputError if there is no ffmpeg, or the folder cannot be made.
  explicit Video(const fs::path& file) : file_(file), part_(PartOf(file)) {
    Ffmpeg();
    base::MakeFolderOf(file);
  }
  ~Video() {
    ffmpeg_.reset();
    std::error_code ignored;
    fs::remove(part_, ignored);
  }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  // All pictures must have the size of the first one.
  // @throws base::RunError if ffmpeg has failed (a full disk, a kill) or accepts no more input.
  void Add(const image::Image& picture) {
    if (!ffmpeg_) {
      process::Program program;
      program.command =
          base::Split(fmt::format("-loglevel error -y -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} "
                                  "-i - -preset veryfast -pix_fmt yuv420p",
                                  picture.width, picture.height, kFrameRate_hz),
                      ' ');
      program.command.insert(program.command.begin(), Ffmpeg().string());
      program.command.push_back(part_.string());
      program.folder = part_.parent_path();
      program.limit_s = kLimit_s;
      ffmpeg_ = std::make_unique<process::Feed>(program, file_.string());
    }
    ffmpeg_->Write(picture.rgb);
  }

  // @throws base::RunError as in Add, or if there was no picture.
  void Finish() {
    if (!ffmpeg_) throw base::RunError(file_.string() + ": there is nothing to record");
    ffmpeg_->Finish();
    ffmpeg_.reset();
    fs::rename(part_, file_);
  }

 private:
  fs::path file_, part_;
  std::unique_ptr<process::Feed> ffmpeg_;
};

// In a trial, an unknown camera would be a crash of that trial.
// @throws base::InputError naming the camera and those that exist.
void CheckCamera(const trial::Cell& cell, const std::string& camera) {
  constexpr int kSide_px = 16;  // the picture is not used
  std::vector<sim::ObjectModel> models;
  for (const std::string& object : cell.options.objects) {
    models.push_back(trial::ObjectModelOf(cell.options, object));
  }
  sim::World world(cell.options.scene, models, cell.options.physics);
  sim::Renderer(world, kSide_px, kSide_px).Render(world, camera);
}

// What a film shows of an execution besides the scene: the perception, and the states so far.
class FilmState {
 public:
  explicit FilmState(std::string name) : name_(std::move(name)) {}

  void SetScan(const image::Image& perceived) {
    scan_ = draw::Fitted(perceived, kRight_px, kScan_px);
  }

  void Add(const sim::ExecutionState& state) {
    if (stages_.empty() || stages_.back().name != state.stage) {
      if (stages_.empty()) start_s_ = state.time_s;  // the time axis begins with the execution
      stages_.push_back({state.time_s - start_s_, state.stage});
    }
    time_s_.push_back(state.time_s - start_s_);
    force_N_.push_back(state.force_N);
    felt_N_.push_back(state.felt_N);
    slip_mm_.push_back(state.slip_m * base::kMmPerM);
  }

  // The film's picture.
  // @param scene  of kFilmScene_px x kFilmHeight_px
  image::Image Compose(const image::Image& scene) const {
    image::Image picture = draw::Blank(kFilmWidth_px, kFilmHeight_px);
    draw::Paste(scene, 0, 0, picture);
    if (scan_.width > 0) draw::Paste(scan_, kFilmScene_px, 0, picture);
    const std::vector<draw::Trace> traces = {
        {"grip force, commanded [N]", force_N_, kForce_N, kCommand},
        {"grip force, measured [N]", felt_N_, kForce_N, kFelt},
        {"slip in the hand [mm]", slip_mm_, kSlip_mm, kSlip}};
    draw::Paste(draw::DrawStrips(time_s_, traces, stages_, kRight_px, kFilmHeight_px - kScan_px),
                kFilmScene_px, kScan_px, picture);
    const std::string stage = stages_.empty() ? "" : stages_.back().name;
    draw::Paste(draw::Blank(kTitleWidth_px, kTitleHeight_px), 0, 0, picture);
    draw::WriteText(fmt::format("{}   {}", name_, stage), 12, 25, 0.65, picture);
    return picture;
  }

 private:
  std::string name_;   // of the trial
  image::Image scan_;  // empty until there is one
  double start_s_ = 0.0;
  std::vector<double> time_s_, force_N_, felt_N_, slip_mm_;
  std::vector<draw::Mark> stages_;
};

using Corners = std::vector<Eigen::Vector3d>;
using ViewWatcher =
    std::function<void(const std::string&, const sim::World&, const sim::PinholeView&)>;

class FilmRecorder : public trial::Recorder {
 public:
  FilmRecorder(const trial::Cell& cell, const std::string& prefix,
               const experiment::ReplayOptions& options)
      : Recorder(cell, prefix), options_(options), prefix_(prefix), film_(prefix) {
    if (!options.camera.empty()) CheckCamera(cell, options.camera);
    if (!options.video.empty()) video_ = std::make_unique<Video>(options.video);
    detector_ =
        trial::MakeDetector(cell.options, cell.robot, [this](auto&&... all) { OnScene(all...); });
  }

  const trial::Detector& detector() const override { return *detector_; }

  sim::ExecutionObserver Observer() override {
    sim::ExecutionObserver observer;
    if (!options_.snapshots && !video_) return observer;
    observer.frame_period_s = video_ ? 1.0 / kFrameRate_hz : 0.0;
    observer.on_state = [this](const sim::ExecutionState& state) {
      target_ = state.target;
      if (video_) film_.Add(state);
    };
    observer.on_moment = [this](const std::string& moment, sim::World& world) {
      Take(moment, world);
    };
    return observer;
  }

  void SetPrefix(const std::string& prefix) override {
    prefix_ = prefix;
    film_ = FilmState(prefix);
    target_.reset();
    before_.clear();
  }

  void Take(const std::string& moment, sim::World& world) override {
    if (moment == "frame") return AddFrame(world);
    if (moment == "start" && video_) still_ = DrawFrame(world);
    const bool wanted = moments_.empty() || std::ranges::find(moments_, moment) != moments_.end();
    if (!options_.snapshots || !wanted) return;
    if (!renderer_) renderer_ = std::make_unique<sim::Renderer>(world, kWidth_px, kHeight_px);
    // The picture also covers the path of the object since the previous moment.
    Corners corners = CornersOf(world);
    corners.insert(corners.end(), before_.begin(), before_.end());
    Write(moment, Draw(moment, *renderer_, world, corners,
                       {.width_px = kWidth_px, .height_px = kHeight_px}));
    before_.clear();
    if (target_) sim::AddObjectCorners(world, *target_, before_);
  }

  void KeepMoments(const std::vector<std::string>& moments) override { moments_ = moments; }
  void OnView(ViewWatcher on_view) override { on_view_ = std::move(on_view); }

  void Finish() override {
    EndFilm();
    if (sheet_.empty()) return;
    image::WritePng(options_.folder / (name_ + "_sheet.png"),
                    draw::SheetOf(sheet_, kColumns, kTile_px));
  }

 private:
  // "perceived" comes again after a further look.
  void Write(const std::string& what, const image::Image& image) {
    const std::string name = prefix_ + "_" + what;
    const int time = ++written_[name];
    image::WritePng(
        options_.folder / (time == 1 ? name + ".png" : fmt::format("{}_{}.png", name, time)),
        image);
    const std::string caption = prefix_ + " " + (what == "lifted" ? "end of the lift" : what);
    sheet_.push_back({image, time == 1 ? caption : fmt::format("{} ({})", caption, time)});
  }

  void OnScene(const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
               const geometry::Observation& observation) {
    if (!options_.snapshots && !video_) return;
    const auto& image = observation.views.front().image;
    const auto canvas =
        draw::DrawScene(geometry::ToCloud(image).points, scene, {grasps}, cell_.robot.hand());
    const auto view = draw::LookAtScene(scene, image.origins_C.front());
    const auto picture = draw::Render(canvas, view, kWidth_px, kHeight_px);
    if (options_.snapshots) Write("perceived", picture);
    film_.SetScan(picture);
  }

  // Corners of the hand and its target object or, if that is unknown, of all objects.
  Corners CornersOf(const sim::World& world) const {
    Corners corners;
    if (target_) {
      sim::AddHandCorners(world, corners);
      sim::AddObjectCorners(world, *target_, corners);
      return corners;
    }
    for (int object = 0; object < world.objects(); ++object) {
      if (!world.parked(object)) sim::AddObjectCorners(world, object, corners);
    }
    if (corners.empty()) sim::AddHandCorners(world, corners);
    return corners;
  }

  image::Image Draw(const std::string& moment, sim::Renderer& with, sim::World& world,
                    const Corners& corners, const sim::FramingOptions& framing) const {
    if (!options_.camera.empty()) return with.Render(world, options_.camera);
    const sim::PinholeView view = sim::FrameAll(corners, sim::ViewAxes(world), framing);
    if (on_view_) on_view_(moment, world, view);
    return with.Render(world, view);
  }

  image::Image DrawFrame(sim::World& world) {
    if (!film_renderer_) {
      film_renderer_ =
          std::make_unique<sim::Renderer>(world, kFilmScene_px, kFilmHeight_px, kFilmQuality);
    }
    return Draw("frame", *film_renderer_, world, CornersOf(world),
                {.width_px = kFilmScene_px, .height_px = kFilmHeight_px});
  }

  void AddFrame(sim::World& world) {
    if (!video_) return;
    video_->Add(film_.Compose(DrawFrame(world)));
    moved_ = true;
  }

  void EndFilm() const {
    if (!video_) return;
    if (!moved_ && still_.width > 0) {
      const auto picture = film_.Compose(still_);
      for (int i = 0; i < kStill_s * kFrameRate_hz; ++i) video_->Add(picture);
    }
    video_->Finish();
  }

  experiment::ReplayOptions options_;
  std::string prefix_;
  std::vector<std::string> moments_;
  ViewWatcher on_view_;
  std::unique_ptr<sim::Renderer> renderer_, film_renderer_;
  std::unique_ptr<trial::Detector> detector_;
  std::vector<draw::Captioned> sheet_;
  std::unique_ptr<Video> video_;
  FilmState film_;
  image::Image still_;  // the scene before anything moved
  bool moved_ = false;
  std::optional<int> target_;           // target of the execution
  std::map<std::string, int> written_;  // pictures of a name
  Corners before_;                      // corners of the object at the previous moment
};

}  // namespace

std::unique_ptr<trial::Recorder> MakeRecorder(const trial::Cell& cell, const std::string& prefix,
                                              const experiment::ReplayOptions& options) {
  return std::make_unique<FilmRecorder>(cell, prefix, options);
}

}  // namespace rangegrasp::report
