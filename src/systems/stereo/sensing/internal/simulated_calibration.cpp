#include "stereo/sensing/internal/simulated_calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/frames.h"
#include "base/installation.h"
#include "experiment/runner.h"
#include "robot/ik.h"
#include "robot/planning/planning.h"
#include "robot/robot.h"
#include "sensing/line_scanner.h"
#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::stereo {
namespace {

constexpr int kBoard = 0;                // the world's one object
constexpr int kMaxDraws = 10000;         // of a pose before giving up
constexpr int kDrawsOneWay = 3000;       // of a pose with a tilt in one direction
constexpr double kMinDistance_m = 0.50;  // of the board's middle from the camera: the range of the
constexpr double kMaxDistance_m = 0.85;  // objects seen later; the relative pose is good no further
constexpr double kMaxTilt_rad = base::Deg(38.0);  // of the board from facing the camera
constexpr double kBoardMargin_px = 12.0;          // of its corners from the pictures' edges
constexpr double kClearance_m = 0.01;             // of the board from table and arm
constexpr double kMinChange_m = 0.015;  // minimum difference from the scan without the board
constexpr double kLeastTilt = 0.25;     // square of the least tilt, as a share of the greatest
constexpr double kGoldenTurn = 0.6180339887;  // no two of its first multiples are alike

std::filesystem::path ChessboardModel() {
  return base::DataFolder() / "models" / "calibration" / "chessboard" / "chessboard.xml";
}

// The board has no print except its squares.
sensing::StereoCamera Unprinted(sensing::StereoCameraOptions options) {
  options.fine_print = false;
  return sensing::StereoCamera(options);
}

Eigen::Matrix3d Turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

/// True if the board's corners are in the picture, at least this far from its edges.
/// @param place  maps a point of the board to the camera's frame
bool SeesWhole(const Camera& lens, const Eigen::Vector3d& half_board_m, double margin_px,
               const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place) {
  for (const double x : {-half_board_m.x(), half_board_m.x()}) {
    for (const double y : {-half_board_m.y(), half_board_m.y()}) {
      const Eigen::Vector2d pixel = Project(lens, place({x, y, 0.0}));
      if (!(pixel.x() > margin_px && pixel.x() < lens.width - 1 - margin_px &&
            pixel.y() > margin_px && pixel.y() < lens.height - 1 - margin_px)) {
        return false;
      }
    }
  }
  return true;
}

/// Simulates a person who calibrates the stereo camera.
class ChessboardRecorder {
 public:
  explicit ChessboardRecorder(const CalibrationSetup& setup)
      : setup_(setup),
        world_(setup.scene, {{"chessboard", ChessboardModel()}}, {}),
        X_WS_(world_.SitePose("scanner")),
        camera_(Unprinted(setup.camera)),
        renderer_(camera_.RendererOf(world_)) {
    world_.PlaceObject(kBoard, base::Pose::Identity());
    half_board_m_ = 0.5 * world_.ObjectBounds(kBoard).sizes();
    world_.ParkObject(kBoard);
    base::Rng rng(base::DeriveSeed(setup.seed, "empty"));
    empty_ = sensing::ScanScene(world_.VisualMeshes(), X_WS_, setup.scanner, rng);
  }

  /// View of the next pose of the board; depends on the setup and the number of calls.
  BoardView Next() {
    const std::uint64_t seed = base::DeriveSeed(setup_.seed, views_);
    base::Rng place(base::DeriveSeed(seed, "place"));
    int draws = 0;
    // In some directions there is no room between table and arm: then any other is used.
    while (!Fits(DrawPlace(draws < kDrawsOneWay ? 0.1 : 0.5, place))) {
      if (++draws == kMaxDraws) {
        throw base::RunError("no pose of the chessboard in which both pictures show it completely");
      }
    }
    base::Rng photo(base::DeriveSeed(seed, "photo"));
    sensing::StereoShot shot = camera_.Photograph(world_, *renderer_, X_WS_, photo);
    base::Rng scan(base::DeriveSeed(seed, "scan"));
    return {fmt::format("view {}", ++views_), std::move(shot.photos.left),
            std::move(shot.photos.right), ScanBoard(scan), empty_.view.X_CV.translation()};
  }

 private:
  // Draws a pose in the left picture, roughly facing the camera, rotated in its plane by less than
  // the right angle that would exchange its edges.
  base::Pose DrawPlace(double width, base::Rng& rng) const {
    const double depth_m = rng.Uniform(kMinDistance_m, kMaxDistance_m);
    const double right = rng.Uniform(-0.5, 0.5) * setup_.camera.width;
    const double down = rng.Uniform(-0.5, 0.5) * setup_.camera.height;
    const double tilt = kMaxTilt_rad * std::sqrt(rng.Uniform(kLeastTilt, 1.0));
    // Each view is tilted in another direction, so that even a few of them cover all directions.
    const double tilt_towards =
        2.0 * base::kPi * (kGoldenTurn * static_cast<double>(views_) + rng.Uniform(-width, width));
    const double roll = rng.Uniform(-base::Deg(30.0), base::Deg(30.0));
    const Eigen::Vector3d place_C(right / setup_.camera.focal_px, down / setup_.camera.focal_px,
                                  1.0);
    const Eigen::Vector3d tilt_axis(std::cos(tilt_towards), std::sin(tilt_towards), 0.0);
    // The print faces the camera: z of the board towards it, y up in the picture.
    const Eigen::Matrix3d R_CBoard = Turn(tilt, tilt_axis) * Turn(roll, Eigen::Vector3d::UnitZ()) *
                                     Turn(base::kPi, Eigen::Vector3d::UnitX());
    return X_WC(setup_.camera.left_pan_rad) * base::MakePose(R_CBoard, depth_m * place_C);
  }

  base::Pose X_WC(double pan_rad) const {
    return X_WS_ * sensing::CameraInHead(setup_.camera, pan_rad);
  }

  bool IsSeenWhole(const base::Pose& X_WBoard, double pan_rad) const {
    const base::Pose X_CBoard = X_WC(pan_rad).inverse() * X_WBoard;
    return SeesWhole(sensing::LensOf(setup_.camera), half_board_m_, kBoardMargin_px,
                     [&](const Eigen::Vector3d& p) { return X_CBoard * p; });
  }

  bool Fits(const base::Pose& X_WBoard) {
    if (!IsSeenWhole(X_WBoard, setup_.camera.left_pan_rad)) return false;
    if (!IsSeenWhole(X_WBoard, setup_.camera.right_pan_rad)) return false;
    world_.PlaceObject(kBoard, X_WBoard);
    return world_.ObjectBottom(kBoard) > kClearance_m &&
           world_.RobotDistance(kBoard, kClearance_m) >= kClearance_m;
  }

  // In the frame of the first scan's calibration, because each scan draws its own error.
  geometry::Points ScanBoard(base::Rng& rng) const {
    const sensing::Scan scan =
        sensing::ScanScene(world_.VisualMeshes(), X_WS_, setup_.scanner, rng);
    const base::Pose X_WHead = empty_.view.X_CV;
    const base::Pose X_HeadW = scan.view.X_CV.inverse();
    const auto range = [](const geometry::View& view, std::size_t i) {
      return (view.image.points_C[i] - view.X_CV.translation()).norm();
    };
    geometry::Points board;
    for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
      const Eigen::Vector3d& p = scan.view.image.points_C[i];
      // Where the empty scene has no point there is nothing to compare with.
      if (!p.allFinite() || !empty_.view.image.points_C[i].allFinite()) continue;
      if (range(empty_.view, i) - range(scan.view, i) < kMinChange_m) continue;
      board.push_back(X_WHead * (X_HeadW * p));
    }
    return board;
  }

  const CalibrationSetup& setup_;
  sim::World world_;
  base::Pose X_WS_;
  sensing::StereoCamera camera_;
  std::unique_ptr<sim::Renderer> renderer_;
  Eigen::Vector3d half_board_m_;
  sensing::Scan empty_;
  std::uint64_t views_ = 0;
};

using nlohmann::json;

constexpr double kLimit_s = 600.0;  // sixteen views take ten seconds
constexpr char kCalibrated[] = "calibrated";

/// All numbers of a calibration except the size of its pictures, in a fixed order.
std::vector<double*> NumbersOf(StereoCalibration& c) {
  std::vector<double*> numbers = {&c.camera.fx, &c.camera.fy,       &c.camera.cx,     &c.camera.cy,
                                  &c.camera.k1, &c.camera.k2,       &c.camera.p1,     &c.camera.p2,
                                  &c.camera.k3, &c.reprojection_px, &c.registration_m};
  for (base::Pose* pose : {&c.X_WL, &c.X_WR}) {
    for (int i = 0; i < 16; ++i) numbers.push_back(pose->matrix().data() + i);
  }
  return numbers;
}

experiment::Result Calibrate(const CalibrationSetup& setup) {
  experiment::Result result;
  try {
    StereoCalibration calibration = CalibrateSimulated(setup, {}).calibration;
    json numbers;
    for (const double* number : NumbersOf(calibration)) numbers.push_back(*number);
    result.data = json{{"numbers", numbers}}.dump();
    result.outcome = kCalibrated;
  } catch (const base::InputError& error) {
    result.outcome = "refused";
    result.detail = error.what();
  }
  return result;
}

constexpr int kTriesAView = 60;
constexpr double kLieFlat_m = 0.001;  // height above the table when it is released
constexpr double kMargin_px = 15.0;   // of the board from the picture's edges
// Distance of the camera from the board's middle.
constexpr double kNearest_m = 0.42, kFarthest_m = 0.55;
constexpr double kMaxLean_rad = base::Deg(40.0);  // of the line of sight from straight down
constexpr double kMaxRoll_rad = base::Deg(25.0);  // of the camera about it
// Error of the hand's pose according to the arm: its repeatability, one draw per picture.
constexpr double kArmSigma_m = 0.0001;
constexpr double kArmSigma_rad = base::Deg(0.02);

class CalibrationCell {
 public:
  explicit CalibrationCell(const CalibrationSetup& setup)
      : setup_(setup),
        robot_(robot::Robot::Load(setup.scene)),
        world_(setup.scene, {{"chessboard", ChessboardModel()}}, {}),
        camera_(Unprinted(setup.camera)),
        lens_(sensing::LensOf(setup.camera)),
        X_SC_(sensing::CameraInHead(setup.camera, 0.0)),
        planner_(robot_, {}),
        rng_(base::DeriveSeed(setup.seed, "hand_eye")) {
    if (!robot_.X_HWristScanner) {
      throw base::InputError(setup.scene.string() +
                             ": has no camera to calibrate: a site \"wrist_scanner\" on the arm's "
                             "last link is needed, as in scenes/tabletop_wrist.xml");
    }
    LayBoard();
    renderer_ = camera_.RendererOf(world_);
    planning::PlanningScene scene;
    scene.table_z_m = robot_.X_WWorkspace.translation().z();
    planner_.SetScene(std::move(scene));
  }

  HandEyeViews Run(const std::function<bool(const image::Image&)>& is_good) {
    HandEyeViews run{.record = {lens_, X_SC_, {}}, .pictures = {}, .X_HS = robot_.X_HWristScanner};
    for (int taken = 0; static_cast<int>(run.pictures.size()) < setup_.views; ++taken) {
      if (taken == 2 * setup_.views) {
        throw base::RunError(fmt::format(
            "{}: of {} pictures only {} show the chessboard well enough (light, shadow, blur)",
            setup_.scene.string(), taken, run.pictures.size()));
      }
      GoToView(taken);
      const base::Pose X_WH = robot_.HandPose(world_.ArmPositions());
      image::Image picture =
          camera_.Picture(world_, *renderer_, X_WH * *run.X_HS * X_SC_, rng_.Next());
      if (!is_good(picture)) continue;
      run.pictures.push_back(std::move(picture));
      run.record.X_WH.push_back(X_WH * base::DrawRigidError(kArmSigma_m, kArmSigma_rad, rng_));
    }
    return run;
  }

 private:
  void LayBoard() {
    world_.SetArm(robot_.home);
    base::Pose X_WBoard = base::Pose::Identity();
    X_WBoard.translation() = robot_.X_WWorkspace.translation();
    world_.PlaceObject(kBoard, X_WBoard);
    X_WBoard.translation().z() +=
        kLieFlat_m + robot_.X_WWorkspace.translation().z() - world_.ObjectBottom(kBoard);
    world_.PlaceObject(kBoard, X_WBoard);
    world_.Settle();
    X_WBoard_ = world_.ObjectPose(kBoard);
    half_m_ = 0.5 * world_.ObjectBounds(kBoard).sizes();
  }

  base::Pose DrawCamera(int view) {
    const double distance_m = rng_.Uniform(kNearest_m, kFarthest_m);
    const double lean_rad = kMaxLean_rad * std::sqrt(rng_.Uniform(0.1, 1.0));
    const double around_rad = 2.0 * base::kPi * (kGoldenTurn * view + rng_.Uniform(-0.25, 0.25));
    const double roll_rad = rng_.Uniform(-kMaxRoll_rad, kMaxRoll_rad);
    const Eigen::Vector3d away_W(std::sin(lean_rad) * std::cos(around_rad),
                                 std::sin(lean_rad) * std::sin(around_rad), std::cos(lean_rad));
    const Eigen::Vector3d z = -away_W;
    const Eigen::Vector3d y = z.cross(Eigen::Vector3d::UnitX()).normalized();
    Eigen::Matrix3d R;
    R << y.cross(z), y, z;
    // Quarter turns about the line of sight: the arm does not reach all of them.
    const double turn_rad = 0.5 * base::kPi * std::floor(rng_.Uniform(0.0, 4.0));
    return base::MakePose(R * Eigen::AngleAxisd(roll_rad + turn_rad, Eigen::Vector3d::UnitZ()),
                          X_WBoard_.translation() + distance_m * away_W);
  }

  std::optional<base::JointTrajectory> WayTo(const base::Pose& X_WC) {
    const base::Pose X_WH = X_WC * X_SC_.inverse() * robot_.X_HWristScanner->inverse();
    const Eigen::VectorXd now = world_.ArmPositions();
    for (const Eigen::VectorXd& q : robot::SolveIk(robot_, X_WH, now, {}, rng_)) {
      if (!planner_.IsFree(q)) continue;
      if (auto way = planner_.PlanMotion(now, q, rng_)) return way;
    }
    return std::nullopt;
  }

  void GoToView(int view) {
    for (int i = 0; i < kTriesAView; ++i) {
      const base::Pose X_WC = DrawCamera(view);
      const auto place = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
        return X_WC.inverse() * (X_WBoard_ * p);
      };
      if (!SeesWhole(lens_, half_m_, kMargin_px, place)) continue;
      const auto way = WayTo(X_WC);
      if (way && sim::MoveArm(world_, *way).arrived) return;
    }
    throw base::RunError(
        fmt::format("{}: the arm reaches no pose in which the camera sees the complete chessboard "
                    "(picture {}, {} tried)",
                    setup_.scene.string(), view + 1, kTriesAView));
  }

  const CalibrationSetup& setup_;
  robot::Robot robot_;
  sim::World world_;
  sensing::StereoCamera camera_;
  Camera lens_;
  base::Pose X_SC_;
  planning::Planner planner_;
  std::unique_ptr<sim::Renderer> renderer_;
  base::Rng rng_;
  base::Pose X_WBoard_;
  Eigen::Vector3d half_m_;
};

}  // namespace

CalibrationResult CalibrateSimulated(const CalibrationSetup& setup,
                                     const ChessboardOptions& chessboard,
                                     const std::function<void(const BoardView&)>& look_on) {
  ChessboardRecorder recorder(setup);
  const int views = setup.views;
  std::vector<BoardSighting> boards;
  int refused = 0;
  for (int wanted = views;; wanted += std::max(1, views / 4)) {
    while (static_cast<int>(boards.size()) < wanted) {
      const BoardView view = recorder.Next();
      if (look_on) look_on(view);
      try {
        boards.push_back(FindBoard(view, chessboard));
      } catch (const base::InputError&) {
        if (++refused > views) throw;
      }
    }
    try {
      return CalibrateStereo(boards, setup.camera.width, setup.camera.height, chessboard);
    } catch (const base::InputError&) {
      if (wanted >= 2 * views) throw;  // more views may be less alike
    }
  }
}

StereoCalibration CalibrateApart(const CalibrationSetup& setup) {
  const experiment::Case which{"stereo_calibration", "", setup.seed, {}};
  const experiment::Result result = experiment::RunApart(
      which, kLimit_s, [&setup](const experiment::Case&) { return Calibrate(setup); });
  if (result.outcome != kCalibrated) {
    throw base::InputError("the stereo camera's calibration: " + result.detail);
  }
  StereoCalibration calibration;
  calibration.camera.width = setup.camera.width;
  calibration.camera.height = setup.camera.height;
  const json numbers = json::parse(result.data).at("numbers");
  std::size_t next = 0;
  for (double* number : NumbersOf(calibration)) *number = numbers.at(next++);
  return calibration;
}

HandEyeViews SimulateHandEye(const CalibrationSetup& setup,
                             const std::function<bool(const image::Image&)>& is_good) {
  return CalibrationCell(setup).Run(is_good);
}

}  // namespace rangegrasp::stereo
