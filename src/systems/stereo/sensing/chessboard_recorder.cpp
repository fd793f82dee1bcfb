#include "stereo/sensing/chessboard_recorder.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/error.h"
#include "sensing/line_scanner.h"
#include "sim/world.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::sensing {
namespace {

constexpr int kBoard = 0;                     // the world's one object
constexpr int kMaxDraws = 10000;              // of a place, before it is said that there is none
constexpr int kDrawsOneWay = 3000;            // of a place with a tilt in one direction
constexpr double kLeastTilt = 0.25;           // the square of a share of the greatest tilt
constexpr double kGoldenTurn = 0.6180339887;  // of which no few multiples are alike

// Nothing is printed on the board beside its squares.
StereoCameraOptions Unprinted(StereoCameraOptions options) {
  options.fine_print = false;
  return options;
}

Eigen::Matrix3d Turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

}  // namespace

struct ChessboardRecorder::Impl {
  StereoCameraOptions camera_options;
  LineScannerOptions scanner;
  ChessboardRecordOptions options;
  std::uint64_t seed;
  sim::World world;
  base::Pose X_WS;
  StereoCamera camera;
  std::unique_ptr<sim::Renderer> renderer;
  Eigen::Vector3d half_board_m;
  Scan empty;
  std::uint64_t views = 0;

  Impl(const std::filesystem::path& scene, const std::filesystem::path& chessboard,
       const StereoCameraOptions& camera_used, const LineScannerOptions& scanner_used,
       const ChessboardRecordOptions& how, std::uint64_t seed_used)
      : camera_options(camera_used),
        scanner(scanner_used),
        options(how),
        seed(seed_used),
        world(scene, {{"chessboard", chessboard}}, {}),
        X_WS(world.SitePose("scanner")),
        camera(Unprinted(camera_used)),
        renderer(camera.RendererOf(world)) {
    world.PlaceObject(kBoard, base::Pose::Identity());
    half_board_m = 0.5 * world.ObjectBounds(kBoard).sizes();
    world.ParkObject(kBoard);
    base::Rng rng(base::DeriveSeed(seed, "empty"));
    empty = ScanScene(world.VisualMeshes(), X_WS, scanner, rng);
  }

  base::Pose DrawPlace(std::uint64_t number, double width, base::Rng& rng) const;
  bool SeenWhole(const base::Pose& X_WBoard, double pan_rad) const;
  bool Fits(const base::Pose& X_WBoard);
  geometry::Points ScanBoard(base::Rng& rng) const;
};

// Somewhere in the left picture, roughly facing the camera, turned in its plane by less than the
// right angle that would exchange its edges.
base::Pose ChessboardRecorder::Impl::DrawPlace(std::uint64_t number, double width,
                                               base::Rng& rng) const {
  const double depth_m = rng.Uniform(options.min_distance_m, options.max_distance_m);
  const double right = rng.Uniform(-0.5, 0.5) * camera_options.width;
  const double down = rng.Uniform(-0.5, 0.5) * camera_options.height;
  const double tilt = options.max_tilt_rad * std::sqrt(rng.Uniform(kLeastTilt, 1.0));
  // Each view is tilted another way, so that even a few of them are spread all round.
  const double tilt_towards =
      2.0 * base::kPi * (kGoldenTurn * static_cast<double>(number) + rng.Uniform(-width, width));
  const double roll = rng.Uniform(-base::Deg(30.0), base::Deg(30.0));
  const Eigen::Vector3d place_C(right / camera_options.focal_px, down / camera_options.focal_px,
                                1.0);
  const Eigen::Vector3d tilt_axis(std::cos(tilt_towards), std::sin(tilt_towards), 0.0);
  // The print faces the camera: z of the board towards it, y up in the picture.
  const Eigen::Matrix3d R_CBoard = Turn(tilt, tilt_axis) * Turn(roll, Eigen::Vector3d::UnitZ()) *
                                   Turn(base::kPi, Eigen::Vector3d::UnitX());
  const base::Pose X_WC = X_WS * CameraInHead(camera_options, camera_options.left_pan_rad);
  return X_WC * base::MakePose(R_CBoard, depth_m * place_C);
}

bool ChessboardRecorder::Impl::SeenWhole(const base::Pose& X_WBoard, double pan_rad) const {
  const stereo::Camera lens = LensOf(camera_options);
  const base::Pose X_CBoard = (X_WS * CameraInHead(camera_options, pan_rad)).inverse() * X_WBoard;
  for (const double x : {-half_board_m.x(), half_board_m.x()}) {
    for (const double y : {-half_board_m.y(), half_board_m.y()}) {
      const Eigen::Vector2d pixel = stereo::Project(lens, X_CBoard * Eigen::Vector3d(x, y, 0.0));
      const bool inside = pixel.x() > options.margin_px && pixel.y() > options.margin_px &&
                          pixel.x() < camera_options.width - 1 - options.margin_px &&
                          pixel.y() < camera_options.height - 1 - options.margin_px;
      if (!inside) return false;
    }
  }
  return true;
}

bool ChessboardRecorder::Impl::Fits(const base::Pose& X_WBoard) {
  if (!SeenWhole(X_WBoard, camera_options.left_pan_rad)) return false;
  if (!SeenWhole(X_WBoard, camera_options.right_pan_rad)) return false;
  world.PlaceObject(kBoard, X_WBoard);
  return world.ObjectBottom(kBoard) > options.clearance_m &&
         world.RobotDistance(kBoard, options.clearance_m) >= options.clearance_m;
}

// In the frame of the first scan's calibration: each scan draws an error of its own.
geometry::Points ChessboardRecorder::Impl::ScanBoard(base::Rng& rng) const {
  const Scan scan = ScanScene(world.VisualMeshes(), X_WS, scanner, rng);
  const base::Pose X_WHead = empty.view.X_CV;
  const base::Pose X_HeadW = scan.view.X_CV.inverse();
  const auto range = [](const geometry::View& view, std::size_t i) {
    return (view.image.points_C[i] - view.X_CV.translation()).norm();
  };
  geometry::Points board;
  for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p = scan.view.image.points_C[i];
    // Where the empty scene gave nothing there is nothing to differ from.
    if (!p.allFinite() || !empty.view.image.points_C[i].allFinite()) continue;
    if (range(empty.view, i) - range(scan.view, i) < options.min_change_m) continue;
    board.push_back(X_WHead * (X_HeadW * p));
  }
  return board;
}

ChessboardRecorder::ChessboardRecorder(const std::filesystem::path& scene,
                                       const std::filesystem::path& chessboard,
                                       const StereoCameraOptions& camera,
                                       const LineScannerOptions& scanner,
                                       const ChessboardRecordOptions& options, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(scene, chessboard, camera, scanner, options, seed)) {}

ChessboardRecorder::~ChessboardRecorder() = default;

stereo::BoardView ChessboardRecorder::Next() {
  const std::uint64_t number = impl_->views++;
  const std::uint64_t seed = base::DeriveSeed(impl_->seed, number);
  base::Rng place(base::DeriveSeed(seed, "place"));
  int draws = 0;
  // Some ways there is no room between table and arm: then any other.
  const auto width = [&draws] { return draws < kDrawsOneWay ? 0.1 : 0.5; };
  while (!impl_->Fits(impl_->DrawPlace(number, width(), place))) {
    if (++draws == kMaxDraws) {
      throw base::RunError("no place for the chessboard in which both pictures show it whole");
    }
  }
  base::Rng photo(base::DeriveSeed(seed, "photo"));
  StereoShot shot = impl_->camera.Photograph(impl_->world, *impl_->renderer, impl_->X_WS, photo);
  stereo::BoardView view;
  view.name = fmt::format("view {}", number + 1);
  view.left = std::move(shot.photos.left);
  view.right = std::move(shot.photos.right);
  base::Rng scan(base::DeriveSeed(seed, "scan"));
  view.laser_W = impl_->ScanBoard(scan);
  view.laser_origin_W = impl_->empty.view.X_CV.translation();
  return view;
}

stereo::CalibrationResult CalibrateSimulated(
    ChessboardRecorder& recorder, int views, const StereoCameraOptions& camera,
    const stereo::ChessboardOptions& chessboard,
    const std::function<void(const stereo::BoardView&)>& look_on) {
  std::vector<stereo::BoardSighting> boards;
  int refused = 0;
  for (int wanted = views;; wanted += std::max(1, views / 4)) {
    while (static_cast<int>(boards.size()) < wanted) {
      const stereo::BoardView view = recorder.Next();
      if (look_on) look_on(view);
      try {
        boards.push_back(stereo::FindBoard(view, chessboard));
      } catch (const base::InputError&) {
        if (++refused > views) throw;
      }
    }
    try {
      return stereo::CalibrateStereo(boards, camera.width, camera.height, chessboard);
    } catch (const base::InputError&) {
      if (wanted >= 2 * views) throw;  // more of them may be less alike
    }
  }
}

}  // namespace rangegrasp::sensing
