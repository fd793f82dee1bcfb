#include "stereo/sensing/hand_eye_calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/rigid_error.h"
#include "base/rng.h"
#include "robot/ik.h"
#include "robot/planning/planning.h"
#include "robot/robot.h"
#include "sim/move_arm.h"
#include "sim/world.h"
#include "stereo/sensing/stereo_calibration.h"
#include "stereo/sensing/stereo_camera.h"

namespace rangegrasp::trial {
namespace {

constexpr int kBoard = 0;  // the world's one object
constexpr int kTriesAView = 60;
constexpr double kLieFlat_m = 0.001;          // above the table when it is let go
constexpr double kMargin_px = 15.0;           // that the board keeps from the picture's edges
constexpr double kGoldenTurn = 0.6180339887;  // of which no few multiples are alike

/// Nothing is printed on the board beside its squares.
sensing::StereoCameraOptions Unprinted(sensing::StereoCameraOptions options) {
  options.fine_print = false;
  return options;
}

/// The board, the arm and the camera.
class CalibrationCell {
 public:
  explicit CalibrationCell(const HandEyeSetup& setup)
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
                             ": has no site \"wrist_scanner\" on the arm's last link, as "
                             "scenes/tabletop_wrist.xml has: no camera to calibrate");
    }
    LayBoard();
    renderer_ = camera_.RendererOf(world_);
    planning::PlanningScene scene;
    scene.table_z_m = robot_.X_WWorkspace.translation().z();
    planner_.SetScene(std::move(scene));
  }

  HandEyeSimulation Run(const std::function<bool(const image::Image&)>& is_good) {
    HandEyeSimulation run;
    run.X_HS = *robot_.X_HWristScanner;
    run.record.camera = lens_;
    run.record.X_SC = X_SC_;
    for (int taken = 0; static_cast<int>(run.pictures.size()) < setup_.views; ++taken) {
      if (taken == 2 * setup_.views) {
        throw base::RunError(fmt::format(
            "{}: of {} pictures only {} show the chessboard well enough (light, shadow, blur)",
            setup_.scene.string(), taken, run.pictures.size()));
      }
      GoToView(taken);
      const base::Pose X_WH = robot_.HandPose(world_.ArmPositions());
      image::Image picture = camera_.Picture(world_, *renderer_, X_WH * run.X_HS * X_SC_, rng_);
      if (!is_good(picture)) continue;
      run.pictures.push_back(std::move(picture));
      run.record.X_WH.push_back(
          X_WH * base::DrawRigidError(setup_.arm_sigma_m, setup_.arm_sigma_rad, rng_));
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
    const double distance_m = rng_.Uniform(setup_.min_distance_m, setup_.max_distance_m);
    const double lean_rad = setup_.max_lean_rad * std::sqrt(rng_.Uniform(0.1, 1.0));
    const double around_rad = 2.0 * base::kPi * (kGoldenTurn * view + rng_.Uniform(-0.25, 0.25));
    const double roll_rad = rng_.Uniform(-setup_.max_roll_rad, setup_.max_roll_rad);
    const Eigen::Vector3d away_W(std::sin(lean_rad) * std::cos(around_rad),
                                 std::sin(lean_rad) * std::sin(around_rad), std::cos(lean_rad));
    const Eigen::Vector3d z = -away_W;
    const Eigen::Vector3d y = z.cross(Eigen::Vector3d::UnitX()).normalized();
    Eigen::Matrix3d R;
    R << y.cross(z), y, z;
    return base::MakePose(R * Eigen::AngleAxisd(roll_rad + Turn(), Eigen::Vector3d::UnitZ()),
                          X_WBoard_.translation() + distance_m * away_W);
  }

  /// Of the pictures about the line of sight, by quarters: the arm does not reach all of them.
  double Turn() { return 0.5 * base::kPi * std::floor(rng_.Uniform(0.0, 4.0)); }

  bool SeesBoard(const base::Pose& X_WC) const {
    for (const double x : {-half_m_.x(), half_m_.x()}) {
      for (const double y : {-half_m_.y(), half_m_.y()}) {
        const Eigen::Vector2d pixel =
            stereo::Project(lens_, X_WC.inverse() * (X_WBoard_ * Eigen::Vector3d(x, y, 0.0)));
        if (!(pixel.x() > kMargin_px && pixel.x() < lens_.width - 1 - kMargin_px &&
              pixel.y() > kMargin_px && pixel.y() < lens_.height - 1 - kMargin_px)) {
          return false;
        }
      }
    }
    return true;
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
      if (!SeesBoard(X_WC)) continue;
      const auto way = WayTo(X_WC);
      if (way && sim::MoveArm(world_, *way).arrived) return;
    }
    throw base::RunError(
        fmt::format("{}: the arm comes to no place from where the camera sees the chessboard whole "
                    "(picture {}, {} tried)",
                    setup_.scene.string(), view + 1, kTriesAView));
  }

  const HandEyeSetup& setup_;
  robot::Robot robot_;
  sim::World world_;
  sensing::StereoCamera camera_;
  stereo::Camera lens_;
  base::Pose X_SC_;
  planning::Planner planner_;
  std::unique_ptr<sim::Renderer> renderer_;
  base::Rng rng_;
  base::Pose X_WBoard_;
  Eigen::Vector3d half_m_;
};

}  // namespace

HandEyeSimulation SimulateHandEye(const HandEyeSetup& setup,
                                  const std::function<bool(const image::Image&)>& is_good) {
  return CalibrationCell(setup).Run(is_good);
}

}  // namespace rangegrasp::trial
