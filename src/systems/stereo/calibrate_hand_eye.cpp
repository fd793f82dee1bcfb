#include "stereo/calibrate_hand_eye.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/linear_algebra.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "sensing/hand_eye.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;

/// Smaller rotations of the hand determine the camera's position poorly: an error of 0.1 deg in the
/// board's pose is then 1 % of the lever arm from hand to camera, and the position along the axis
/// is not determined.
constexpr double kMinTurn_rad = base::Deg(10.0);
/// Gauss-Newton steps: they start within a millimetre, and each doubles the correct digits.
constexpr int kSteps = 10;
/// Step of the finite differences [m, rad].
constexpr double kDifference = 1e-6;

base::Pose BoardInCamera(const HandEyeView& view, const Camera& camera,
                         const std::vector<Eigen::Vector3d>& corners) {
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> in_picture;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    on_board.emplace_back(corners[i].x(), corners[i].y(), corners[i].z());
    in_picture.emplace_back(view.corners_px[i].x(), view.corners_px[i].y());
  }
  cv::Vec3d turn, shift;
  cv::solvePnP(on_board, in_picture, internal::MatrixOf(camera), internal::DistortionOf(camera),
               turn, shift);
  return internal::PoseOfTurn(turn, shift);
}

base::Pose FirstGuess(std::span<const HandEyeView> views, const std::vector<base::Pose>& X_CB) {
  std::vector<cv::Mat> hand_turns, hand_shifts, board_turns, board_shifts;
  const auto add = [](const base::Pose& X, std::vector<cv::Mat>& turns,
                      std::vector<cv::Mat>& shifts) {
    turns.emplace_back(cv::Mat(internal::FromEigen(X.linear())).clone());
    shifts.emplace_back(cv::Mat(internal::ShiftOf(X)).clone());
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    add(views[i].X_WH, hand_turns, hand_shifts);
    add(X_CB[i], board_turns, board_shifts);
  }
  cv::Matx33d turn;
  cv::Vec3d shift;
  cv::calibrateHandEye(hand_turns, hand_shifts, board_turns, board_shifts, turn, shift,
                       cv::CALIB_HAND_EYE_PARK);
  return internal::PoseOf(turn, shift);
}

/// Differences of the corners from their projections by the two poses, view after view [px].
Eigen::VectorXd Residuals(std::span<const HandEyeView> views, const Camera& camera,
                          const std::vector<Eigen::Vector3d>& corners, const HandEyeResult& at) {
  Eigen::VectorXd residuals(static_cast<Eigen::Index>(2 * corners.size() * views.size()));
  Eigen::Index row = 0;
  for (const HandEyeView& view : views) {
    const base::Pose X_CB = (view.X_WH * at.X_HC).inverse() * at.X_WBoard;
    for (std::size_t i = 0; i < corners.size(); ++i, row += 2) {
      residuals.segment<2>(row) = Project(camera, X_CB * corners[i]) - view.corners_px[i];
    }
  }
  return residuals;
}

/// @param twists  translation and rotation of each of the two poses
HandEyeResult At(const HandEyeResult& from, const Vector12& twists) {
  HandEyeResult result = from;
  result.X_HC = from.X_HC * base::SmallMotion(twists.segment<3>(3), twists.head<3>());
  result.X_WBoard = from.X_WBoard * base::SmallMotion(twists.tail<3>(), twists.segment<3>(6));
  return result;
}

/// Root mean square distance of corners from their projections [px].
double RmsOf(const Eigen::VectorXd& residuals) {
  return std::sqrt(2.0 * residuals.squaredNorm() / static_cast<double>(residuals.size()));
}

void LeastSquares(std::span<const HandEyeView> views, const Camera& camera,
                  const std::vector<Eigen::Vector3d>& corners, HandEyeResult& result) {
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd now = Residuals(views, camera, corners, result);
    Eigen::MatrixXd J(now.size(), 12);
    for (int i = 0; i < 12; ++i) {
      const HandEyeResult moved = At(result, kDifference * Vector12::Unit(i));
      J.col(i) = (Residuals(views, camera, corners, moved) - now) / kDifference;
    }
    result =
        At(result, -base::SolveLdlt<Eigen::Dynamic, 1>(J.transpose() * J, J.transpose() * now));
  }
  result.rms_px = RmsOf(Residuals(views, camera, corners, result));
}

/// Leaves out each view once, starting from the result of all views.
void Jackknife(std::span<const HandEyeView> views, const Camera& camera,
               const std::vector<Eigen::Vector3d>& corners, HandEyeResult& result) {
  double shifts = 0.0, turns = 0.0;
  for (std::size_t left_out = 0; left_out < views.size(); ++left_out) {
    std::vector<HandEyeView> others(views.begin(), views.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    HandEyeResult without = result;
    LeastSquares(others, camera, corners, without);
    const base::Pose apart = result.X_HC.inverse() * without.X_HC;
    shifts += apart.translation().squaredNorm();
    const double turn_rad = base::TurnOf(apart.linear()).angle();
    turns += turn_rad * turn_rad;
  }
  const auto n = static_cast<double>(views.size());
  result.shift_error_m = std::sqrt((n - 1.0) / n * shifts);
  result.turn_error_rad = std::sqrt((n - 1.0) / n * turns);
}

void Check(std::span<const HandEyeView> views, const ChessboardOptions& options) {
  const auto corners = static_cast<std::size_t>(options.columns * options.rows);
  for (const HandEyeView& view : views) {
    if (view.corners_px.size() == corners) continue;
    throw std::invalid_argument(fmt::format("CalibrateHandEye: {} corners in a view, not {}",
                                            view.corners_px.size(), corners));
  }
  if (views.size() < static_cast<std::size_t>(options.min_views)) {
    throw base::InputError(fmt::format(
        "{} views are too few to calibrate a camera on the hand; at least {} are needed",
        views.size(), options.min_views));
  }
  double turned_rad = 0.0;
  for (const HandEyeView& view : views) {
    const Eigen::Matrix3d turn = views.front().X_WH.linear().transpose() * view.X_WH.linear();
    turned_rad = std::max(turned_rad, base::TurnOf(turn).angle());
  }
  if (turned_rad < kMinTurn_rad) {
    throw base::InputError(
        fmt::format("the hand turned by only {:.1f} deg between the views, too little to calibrate "
                    "a camera on it; at least {:.0f} deg, about several axes, are needed",
                    turned_rad / base::kDeg, kMinTurn_rad / base::kDeg));
  }
}

int GreyAt(const image::Image& picture, const Eigen::Vector2d& pixel) {
  const std::uint8_t* rgb = NearestPixel(picture, pixel);
  return rgb[0] + rgb[1] + rgb[2];
}

std::string ViewName(std::size_t number) { return fmt::format("view_{:02}", number); }

[[noreturn]] void RefuseFit(std::span<const HandEyeView> views, const Camera& camera,
                            const std::vector<Eigen::Vector3d>& corners,
                            const HandEyeResult& result, double max_px) {
  std::size_t worst = 0;
  double worst_px = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double rms_px = RmsOf(Residuals(views.subspan(i, 1), camera, corners, result));
    if (rms_px <= worst_px) continue;
    worst = i;
    worst_px = rms_px;
  }
  throw base::InputError(fmt::format(
      "the corners are {:.2f} px from where a camera on the hand would see them (maximum {:g}), "
      "most in {} ({:.2f} px): was the board moved, or is it another camera?",
      result.rms_px, max_px, ViewName(worst + 1), worst_px));
}

/// The middle of the square between the first four corners.
Eigen::Vector2d FirstSquare(const std::vector<Eigen::Vector2d>& corners, std::size_t columns) {
  return 0.25 * (corners[0] + corners[1] + corners[columns] + corners[columns + 1]);
}

}  // namespace

std::vector<Eigen::Vector2d> FindBoardCorners(const image::Image& picture, const std::string& name,
                                              const ChessboardOptions& options) {
  if (options.columns % 2 == options.rows % 2) {
    throw base::InputError(
        fmt::format("a board of {} x {} inner corners looks the same from both ends: one number "
                    "must be odd and one even, e.g. 9 x 6",
                    options.columns, options.rows));
  }
  const internal::SingleThread single;
  std::vector<Eigen::Vector2d> corners = FindChessboard(picture, name, options);
  const auto columns = static_cast<std::size_t>(options.columns);
  std::vector<Eigen::Vector2d> reversed(corners.rbegin(), corners.rend());
  // Seen from the other end, dark and light are exchanged.
  if (GreyAt(picture, FirstSquare(reversed, columns)) <
      GreyAt(picture, FirstSquare(corners, columns))) {
    return reversed;
  }
  return corners;
}

HandEyeResult CalibrateHandEye(std::span<const HandEyeView> views, const Camera& camera,
                               const ChessboardOptions& options) {
  Check(views, options);
  const internal::SingleThread single;
  const std::vector<Eigen::Vector3d> corners = CornersOfBoard(options);
  std::vector<base::Pose> X_CB;
  for (const HandEyeView& view : views) X_CB.push_back(BoardInCamera(view, camera, corners));
  HandEyeResult result;
  result.X_HC = FirstGuess(views, X_CB);
  result.X_WBoard = views.front().X_WH * result.X_HC * X_CB.front();
  LeastSquares(views, camera, corners, result);
  double squares = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const base::Pose X_WBoard = views[i].X_WH * result.X_HC * X_CB[i];
    squares += (X_WBoard.translation() - result.X_WBoard.translation()).squaredNorm();
  }
  result.rms_m = std::sqrt(squares / static_cast<double>(views.size()));
  if (!(result.rms_px <= options.max_reprojection_px)) {
    RefuseFit(views, camera, corners, result, options.max_reprojection_px);
  }
  Jackknife(views, camera, corners, result);
  return result;
}

HandEyeRecord ReadHandEyeRecord(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  HandEyeRecord record;
  map.Require("camera");
  auto camera =
      map.Child("camera", "lens of the camera, with the distortion of equations 5.10 to 5.12");
  ReadCamera(camera, record.camera);
  if (map.Has("in_head")) record.X_SC = sensing::ReadPoseOf(map, "in_head");
  while (map.Has(ViewName(record.X_WH.size() + 1))) {
    record.X_WH.push_back(sensing::ReadPoseOf(map, ViewName(record.X_WH.size() + 1)));
  }
  map.Finish();
  return record;
}

void WriteHandEyeRecord(const HandEyeRecord& record, const std::filesystem::path& file) {
  std::string text =
      "# The lens, the camera's pose in its head, and the hand's pose in the arm's frame at each "
      "picture.\n" +
      CameraText("camera", record.camera) + sensing::PoseText("in_head", record.X_SC);
  for (std::size_t i = 0; i < record.X_WH.size(); ++i) {
    text += sensing::PoseText(ViewName(i + 1), record.X_WH[i]);
  }
  base::WriteFile(file, text);
}

}  // namespace rangegrasp::stereo
