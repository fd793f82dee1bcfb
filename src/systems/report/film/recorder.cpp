#include "report/film/recorder.h"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "base/image/png.h"
#include "grasp/scene_view.h"
#include "report/film/film_picture.h"
#include "report/film/sheet.h"
#include "report/film/video.h"
#include "sim/framing.h"
#include "sim/render.h"
#include "trial/registry.h"

namespace rangegrasp::report {
namespace {

// Of pictures [px], and of those on a sheet.
constexpr int kWidth_px = 960;
constexpr int kHeight_px = 720;
constexpr int kTile_px = 480;
constexpr int kColumns = 3;
/// Edges of pixels and shadows of a film's pictures: of one of many, so that each takes a tenth of
/// a second.
constexpr sim::RenderQuality kFilmQuality{.samples = 2, .shadow_px = 2048};
/// A film of a trial in which nothing moved shows its start for so long [s].
constexpr double kStill_s = 2.0;

using Corners = std::vector<Eigen::Vector3d>;

using trial::Cell;
using trial::Detector;

}  // namespace

struct Recorder::Impl {
  const Cell& cell;
  experiment::ReplayOptions options;
  std::string name;
  std::string prefix = name;
  std::function<bool(const std::string&)> wanted = {};
  std::function<void(const std::string&, const sim::World&, const sim::PinholeView&)> on_view = {};
  std::unique_ptr<sim::Renderer> renderer = nullptr, film_renderer = nullptr;
  std::unique_ptr<Detector> detector = nullptr;
  std::vector<draw::Captioned> sheet = {};
  std::unique_ptr<Video> video = nullptr;
  FilmState film{prefix};
  image::Image still = {};  // the scene as it stood before anything moved
  bool moved = false;
  std::optional<int> target = {};  // of the execution
  Corners before = {};             // of the object at the moment before

  void Write(const std::string& what, const image::Image& image) {
    image::WritePng(options.folder / fmt::format("{}_{}.png", prefix, what), image);
    sheet.push_back({image, prefix + " " + what});
  }

  void OnScene(const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
               const geometry::Observation& observation) {
    if (!options.snapshots && !video) return;
    const auto& image = observation.views.front().image;
    const auto canvas =
        draw::DrawScene(geometry::ToCloud(image).points, scene, {grasps}, cell.robot.hand());
    const auto view = draw::LookAtScene(scene, image.origins_C.front());
    const auto picture = draw::Render(canvas, view, kWidth_px, kHeight_px);
    if (options.snapshots) Write("perceived", picture);
    film.SetScan(picture);
  }

  // The hand and what it is about, or, where that is not known, all that lies there.
  Corners CornersOf(const sim::World& world) const {
    Corners corners;
    if (target) {
      sim::AddHandCorners(world, corners);
      sim::AddObjectCorners(world, *target, corners);
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
    if (!options.camera.empty()) return with.Render(world, options.camera);
    const sim::PinholeView view = sim::FrameAll(corners, sim::ViewAxes(world), framing);
    if (on_view) on_view(moment, world, view);
    return with.Render(world, view);
  }

  void OnMoment(const std::string& moment, sim::World& world) {
    if (moment == "frame") return AddFrame(world);
    if (moment == "start" && video) still = DrawFrame(world);
    if (!options.snapshots || (wanted && !wanted(moment))) return;
    if (!renderer) renderer = std::make_unique<sim::Renderer>(world, kWidth_px, kHeight_px);
    // The way that the object has come since the moment before is in the picture, too.
    Corners corners = CornersOf(world);
    corners.insert(corners.end(), before.begin(), before.end());
    Write(moment, Draw(moment, *renderer, world, corners,
                       {.width_px = kWidth_px, .height_px = kHeight_px}));
    before.clear();
    if (target) sim::AddObjectCorners(world, *target, before);
  }

  void OnState(const sim::ExecutionState& state) {
    target = state.target;
    if (video) film.Add(state);
  }

  image::Image DrawFrame(sim::World& world) {
    if (!film_renderer) {
      film_renderer =
          std::make_unique<sim::Renderer>(world, kFilmScene_px, kFilmHeight_px, kFilmQuality);
    }
    return Draw("frame", *film_renderer, world, CornersOf(world),
                {.width_px = kFilmScene_px, .height_px = kFilmHeight_px});
  }

  void AddFrame(sim::World& world) {
    if (!video) return;
    const auto picture = film.Compose(DrawFrame(world));
    video->Add(picture);
    moved = true;
  }

  void EndFilm() const {
    if (!video) return;
    if (!moved && still.width > 0) {
      const auto picture = film.Compose(still);
      for (int i = 0; i < kStill_s * kFrameRate_hz; ++i) video->Add(picture);
    }
    video->Finish();
  }
};

Recorder::Recorder(const Cell& cell, const std::string& prefix,
                   const experiment::ReplayOptions& options)
    : impl_(new Impl{.cell = cell, .options = options, .name = prefix}) {
  if (!options.video.empty()) impl_->video = std::make_unique<Video>(options.video);
  impl_->detector = trial::MakeDetector(cell.options, cell.robot,
                                        [this](auto&&... all) { impl_->OnScene(all...); });
}
Recorder::~Recorder() = default;

const trial::Detector& Recorder::detector() const { return *impl_->detector; }

sim::ExecutionObserver Recorder::Observer() {
  sim::ExecutionObserver observer;
  if (!impl_->options.snapshots && !impl_->video) return observer;
  observer.frame_period_s = impl_->video ? 1.0 / kFrameRate_hz : 0.0;
  observer.on_state = [this](const sim::ExecutionState& state) { impl_->OnState(state); };
  observer.on_moment = [this](const std::string& moment, sim::World& world) {
    impl_->OnMoment(moment, world);
  };
  return observer;
}

void Recorder::SetPrefix(const std::string& prefix) {
  impl_->prefix = prefix;
  impl_->film = FilmState(prefix);
  impl_->target.reset();
  impl_->before.clear();
}

void Recorder::Take(const std::string& moment, sim::World& world) {
  impl_->OnMoment(moment, world);
}

void Recorder::KeepMoments(std::function<bool(const std::string&)> wanted) {
  impl_->wanted = std::move(wanted);
}

void Recorder::OnView(
    std::function<void(const std::string&, const sim::World&, const sim::PinholeView&)> on_view) {
  impl_->on_view = std::move(on_view);
}

void Recorder::Finish() {
  impl_->EndFilm();
  if (impl_->sheet.empty()) return;
  image::WritePng(impl_->options.folder / (impl_->name + "_sheet.png"),
                  draw::SheetOf(impl_->sheet, kColumns, kTile_px));
}

}  // namespace rangegrasp::report
