#include "stereo/calibrate.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "base/error.h"
#include "base/linear_algebra.h"
#include "base/rng.h"
#include "base/units.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

// Section 5.3.2 has two radial and two tangential parameters.
constexpr int kLensFlags = cv::CALIB_FIX_K3;
const cv::TermCriteria kUntilStill(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9);

cv::Size BoardSize(const ChessboardOptions& options) { return {options.columns, options.rows}; }

// Half side of the square around a corner in which its two edges are used: a fifth of the distance
// to the nearest other corner, because another corner in it would bias the result. More pixels than
// kMaxHalf add no information.
int HalfWindow(const std::vector<cv::Point2f>& corners, int columns) {
  constexpr int kMinHalf = 2;
  constexpr int kMaxHalf = 11;
  const auto row = static_cast<std::size_t>(columns);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i > 0) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - 1]));
    if (i >= row) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - row]));
  }
  return std::clamp(static_cast<int>(nearest / 5.0), kMinHalf, kMaxHalf);
}

geometry::Plane LaserPlane(const BoardView& view, const ChessboardOptions& options) {
  const auto refuse = [&view] {
    throw base::InputError(fmt::format("{}: the laser measured no plane of the board in {} points",
                                       view.name, view.laser_W.size()));
  };
  // At least half of the points must be the board's; otherwise this is not its plane.
  constexpr std::uint64_t kAnySeed = 1;  // the same points give the same plane
  base::Rng rng(kAnySeed);
  const auto fit = geometry::FitPlaneRansac(view.laser_W, {100, options.laser_band_m}, rng);
  const std::size_t needed = std::max<std::size_t>(100, view.laser_W.size() / 2);
  if (!fit || fit->inliers.size() < needed) refuse();
  geometry::Plane plane = fit->plane;
  // Remaining mixed points lie outside the noise.
  double band_m = options.laser_band_m;
  for (int round = 0; round < 3; ++round) {
    geometry::Points near;
    double squares = 0.0;
    for (const Eigen::Vector3d& p : view.laser_W) {
      const double distance = plane.Distance(p);
      if (std::abs(distance) > band_m) continue;
      near.push_back(p);
      squares += distance * distance;
    }
    const auto refined = geometry::FitPlane(near);
    if (!refined) refuse();
    plane = *refined;
    band_m = 3.0 * std::sqrt(squares / static_cast<double>(near.size()));
  }
  return plane.Distance(view.laser_origin_W) < 0.0 ? plane.Flipped() : plane;
}

std::vector<cv::Point2f> Points2(const std::vector<Eigen::Vector2d>& from) {
  std::vector<cv::Point2f> to;
  for (const Eigen::Vector2d& p : from) {
    to.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return to;
}

// The lens and the board's pose in the camera's frame at each picture, left ones first.
struct Lens {
  cv::Mat matrix = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat distortion = cv::Mat::zeros(5, 1, CV_64F);
  std::vector<base::Pose> X_CBoard;
};

struct Corners {
  std::vector<std::vector<cv::Point3f>> board;  // one list per pair
  std::vector<std::vector<cv::Point2f>> left, right;
};

Corners CornersOf(std::span<const BoardSighting> boards, const ChessboardOptions& options) {
  std::vector<cv::Point3f> board;
  for (const Eigen::Vector3d& p : CornersOfBoard(options)) {
    board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
  }
  Corners corners;
  for (const BoardSighting& sighting : boards) {
    if (sighting.left_px.size() != board.size() || sighting.right_px.size() != board.size()) {
      throw std::invalid_argument(fmt::format("{}: {} and {} corners; there must be {}",
                                              sighting.name, sighting.left_px.size(),
                                              sighting.right_px.size(), board.size()));
    }
    corners.board.push_back(board);
    corners.left.push_back(Points2(sighting.left_px));
    corners.right.push_back(Points2(sighting.right_px));
  }
  return corners;
}

Lens CalibrateLens(const Corners& corners, const cv::Size& size, double& residual_px) {
  auto boards = corners.board;
  boards.insert(boards.end(), corners.board.begin(), corners.board.end());
  auto seen = corners.left;
  seen.insert(seen.end(), corners.right.begin(), corners.right.end());
  Lens lens;
  std::vector<cv::Mat> turns, shifts;
  residual_px = cv::calibrateCamera(boards, seen, size, lens.matrix, lens.distortion, turns, shifts,
                                    kLensFlags, kUntilStill);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    lens.X_CBoard.push_back(internal::PoseOfTurn(turns[i], shifts[i]));
  }
  return lens;
}

// The relative pose of all pairs, by least squares over all corners; starts from that of one pair.
base::Pose CalibrateTurn(const Corners& corners, Lens& lens, const cv::Size& size,
                         double& residual_px) {
  const std::size_t pairs = corners.left.size();
  const base::Pose X_RL = RightInLeft(lens.X_CBoard.front(), lens.X_CBoard[pairs]).inverse();
  cv::Mat rotation(internal::FromEigen(X_RL.linear()));
  cv::Mat shift(internal::ShiftOf(X_RL));
  cv::Mat essential, fundamental, residuals;
  residual_px = cv::stereoCalibrate(
      corners.board, corners.left, corners.right, lens.matrix, lens.distortion, lens.matrix,
      lens.distortion, size, rotation, shift, essential, fundamental, residuals,
      cv::CALIB_FIX_INTRINSIC | cv::CALIB_USE_EXTRINSIC_GUESS, kUntilStill);
  return internal::PoseOf(rotation, shift).inverse();
}

// A pair for registration: a corner in the left camera's frame, and the plane it lies in.
struct CornerOnPlane {
  Eigen::Vector3d p_L;
  geometry::Plane plane_W;
};

double RootMeanSquare(std::span<const CornerOnPlane> pairs, const base::Pose& X_WL) {
  double squares = 0.0;
  for (const CornerOnPlane& pair : pairs) {
    const double distance = pair.plane_W.Distance(X_WL * pair.p_L);
    squares += distance * distance;
  }
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

// The rotation that aligns the normals (Kabsch), then the translation for it.
base::Pose FirstRegistration(std::span<const Eigen::Vector3d> normals_L,
                             std::span<const CornerOnPlane> pairs) {
  Eigen::Matrix3d joint = Eigen::Matrix3d::Zero();
  const std::size_t each = pairs.size() / normals_L.size();
  for (std::size_t i = 0; i < normals_L.size(); ++i) {
    joint += pairs[i * each].plane_W.normal * normals_L[i].transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(joint, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  sign.z() = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d R_WL = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const CornerOnPlane& pair : pairs) {
    const Eigen::Vector3d& n = pair.plane_W.normal;
    sum += n * n.transpose();
    right -= n * pair.plane_W.Distance(R_WL * pair.p_L);
  }
  return base::MakePose(R_WL, base::SolveLdlt(sum, right));
}

/// A Gauss-Newton step towards the corners' planes, over a small motion on the left of the pose (N
/// = 6) and also over a scale factor of all that the camera sees (N = 7).
template <int N>
struct PlaneStep {
  Eigen::Matrix<double, N, N> sum = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> motion;
  double squares = 0.0;  // of the distances before the step

  PlaneStep(std::span<const CornerOnPlane> pairs, base::Pose& X_WL, double factor = 1.0) {
    Eigen::Matrix<double, N, 1> right = Eigen::Matrix<double, N, 1>::Zero();
    for (const CornerOnPlane& pair : pairs) {
      const Eigen::Vector3d& n = pair.plane_W.normal;
      const Eigen::Vector3d p_W = X_WL * (factor * pair.p_L);
      Eigen::Matrix<double, N, 1> slope;
      slope.template head<6>() << p_W.cross(n), n;
      if constexpr (N == 7) slope[6] = n.dot(X_WL.linear() * pair.p_L);
      const double distance = pair.plane_W.Distance(p_W);
      sum += slope * slope.transpose();
      right -= slope * distance;
      squares += distance * distance;
    }
    motion = sum.ldlt().solve(right);
    X_WL = base::SmallMotion(motion.template head<3>(), motion.template segment<3>(3)) * X_WL;
  }
};

base::Pose Register(base::Pose X_WL, std::span<const CornerOnPlane> pairs) {
  constexpr int kMaxSteps = 30;
  constexpr double kStill = 1e-12;  // [m] and [rad]
  for (int step = 0; step < kMaxSteps; ++step) {
    if (PlaneStep<6>(pairs, X_WL).motion.norm() < kStill) break;
  }
  X_WL.linear() = Eigen::Quaterniond(X_WL.linear()).normalized().toRotationMatrix();
  return X_WL;
}

// Scale factor of all that the camera sees that fits the planes best, and its standard error. A
// board with larger squares looks like one further away, so only the laser detects squares of
// another size. If all boards are about equally far away, the pose absorbs most of the error.
std::pair<double, double> ScaleOf(base::Pose X_WL, std::span<const CornerOnPlane> pairs,
                                  std::size_t boards) {
  constexpr int kRefineSteps = 10;  // from a nearly correct pose
  double scale = 1.0, variance = 0.0;
  for (int step = 0; step < kRefineSteps; ++step) {
    const PlaneStep<7> refined(pairs, X_WL, scale);
    scale += refined.motion[6];
    // Corners of one board share its plane's error: a board counts as one measurement.
    variance = refined.squares / static_cast<double>(boards) * refined.sum.inverse()(6, 6);
  }
  return {scale, std::sqrt(variance)};
}

// The point nearest to the two rays that see it.
Eigen::Vector3d Between(const Eigen::Vector3d& ray_L, const base::Pose& X_LR,
                        const Eigen::Vector3d& ray_R) {
  const Eigen::Vector3d a = ray_L.normalized();
  const Eigen::Vector3d b = (X_LR.linear() * ray_R).normalized();
  const Eigen::Vector3d& c = X_LR.translation();
  const double cosine = a.dot(b);
  const double below = 1.0 - cosine * cosine;
  const double along_a = (a.dot(c) - cosine * b.dot(c)) / below;
  const double along_b = (cosine * a.dot(c) - b.dot(c)) / below;
  return 0.5 * (along_a * a + c + along_b * b);
}

// Spread of the boards' normals: the sine of their smallest spread.
double NormalSpread(std::span<const BoardSighting> boards) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const BoardSighting& board : boards) {
    sum += board.plane_W.normal * board.plane_W.normal.transpose();
  }
  const auto axes = base::SymmetricEigen<3>(sum / static_cast<double>(boards.size()));
  return std::sqrt(std::max(0.0, axes.values[0]));
}

void CheckBoards(std::span<const BoardSighting> boards, const ChessboardOptions& options) {
  if (static_cast<int>(boards.size()) < options.min_views) {
    throw base::InputError(
        fmt::format("{} views of the chessboard are too few to calibrate; at least {} are needed",
                    boards.size(), options.min_views));
  }
  const double spread = NormalSpread(boards);
  if (spread < std::sin(options.min_spread_rad)) {
    throw base::InputError(fmt::format(
        "the chessboard is tilted too little between its views: by {:.1f} deg; at least {:.1f} are "
        "needed",
        base::ToDeg(std::asin(std::min(1.0, spread))), base::ToDeg(options.min_spread_rad)));
  }
}

void CheckResiduals(const CalibrationResult& result, const ChessboardOptions& options) {
  const StereoCalibration& calibration = result.calibration;
  if (!(calibration.reprojection_px <= options.max_reprojection_px)) {
    throw base::InputError(
        fmt::format("the chessboard's corners have a reprojection error of {:.2f} px rms (at most "
                    "{:.2f} is allowed): is the board flat, and did one camera take all pictures, "
                    "turning by the same angles each time?",
                    calibration.reprojection_px, options.max_reprojection_px));
  }
  constexpr double kSurely = 3.0;  // standard errors
  if (std::abs(result.scale - 1.0) >
      std::max(options.max_scale_error, kSurely * result.scale_error)) {
    throw base::InputError(fmt::format(
        "the laser's planes do not agree with the chessboard's size: are its squares {:g} mm? The "
        "planes fit squares of {:.2f} mm",
        options.square_m * base::kMmPerM, result.scale * options.square_m * base::kMmPerM));
  }
  if (!(calibration.registration_m <= options.max_registration_m)) {
    const double off_m = calibration.registration_m;  // meaningless if the fit diverged
    throw base::InputError(fmt::format(
        "the chessboard's corners are {} off the laser's planes (rms; maximum {:.2f} mm): are its "
        "squares {:g} mm, and was the same board scanned at the same position?",
        off_m <= 1.0 ? fmt::format("{:.2f} mm", off_m * base::kMmPerM) : "more than 1 m",
        options.max_registration_m * base::kMmPerM, options.square_m * base::kMmPerM));
  }
}

Camera CameraOf(const Lens& lens, int width, int height) {
  const cv::Matx33d m = lens.matrix;
  const auto k = [&](int i) { return lens.distortion.at<double>(i); };
  return {width, height, m(0, 0), m(1, 1), m(0, 2), m(1, 2), k(0), k(1), k(2), k(3), k(4)};
}

// The corners of each board from both pictures, by one camera, with the laser's plane of it.
std::vector<CornerOnPlane> CornersOnPlanes(std::span<const BoardSighting> boards, const Lens& lens,
                                           const base::Pose& X_LR,
                                           const ChessboardOptions& options) {
  const std::vector<Eigen::Vector3d> corners = CornersOfBoard(options);
  std::vector<CornerOnPlane> pairs;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    const base::Pose& X_LBoard = lens.X_CBoard[i];
    const base::Pose X_LBoard_by_right = X_LR * lens.X_CBoard[boards.size() + i];
    for (const Eigen::Vector3d& corner : corners) {
      pairs.push_back({X_LBoard * corner, boards[i].plane_W});
      pairs.push_back({X_LBoard_by_right * corner, boards[i].plane_W});
    }
  }
  return pairs;
}

std::vector<CornerOnPlane> TriangulatedOnPlanes(std::span<const BoardSighting> boards,
                                                const Camera& camera, const base::Pose& X_LR) {
  std::vector<CornerOnPlane> pairs;
  for (const BoardSighting& board : boards) {
    for (std::size_t k = 0; k < board.left_px.size(); ++k) {
      pairs.push_back(
          {Between(RayOf(camera, board.left_px[k]), X_LR, RayOf(camera, board.right_px[k])),
           board.plane_W});
    }
  }
  return pairs;
}

// The boards' normals towards the left camera.
std::vector<Eigen::Vector3d> NormalsOf(const Lens& lens, std::size_t boards) {
  std::vector<Eigen::Vector3d> normals_L;
  for (std::size_t i = 0; i < boards; ++i) {
    Eigen::Vector3d normal = lens.X_CBoard[i].linear().col(2);
    if (normal.dot(lens.X_CBoard[i].translation()) > 0.0) normal = -normal;
    normals_L.push_back(normal);
  }
  return normals_L;
}

}  // namespace

std::vector<Eigen::Vector3d> CornersOfBoard(const ChessboardOptions& options) {
  std::vector<Eigen::Vector3d> corners;
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      corners.emplace_back(column * options.square_m, row * options.square_m, 0.0);
    }
  }
  return corners;
}

std::vector<Eigen::Vector2d> FindChessboard(const image::Image& picture, const std::string& name,
                                            const ChessboardOptions& options) {
  const cv::Mat grey = internal::GreyOf(picture);
  std::vector<cv::Point2f> corners;
  // Fast; the thorough search takes 0.2 s per picture and also finds dimly lit boards.
  if (cv::findChessboardCorners(grey, BoardSize(options), corners)) {
    const int half = HalfWindow(corners, options.columns);
    cv::cornerSubPix(grey, corners, {half, half}, {-1, -1}, kUntilStill);
  } else if (!cv::findChessboardCornersSB(grey, BoardSize(options), corners)) {
    throw base::InputError(
        fmt::format("{}: no chessboard with {} x {} inner corners is completely visible", name,
                    options.columns, options.rows));
  }
  for (const bool upright : {false, true}) {
    const double edge_px =
        cv::estimateChessboardSharpness(grey, BoardSize(options), corners, 0.8F, upright)[0];
    if (!(edge_px <= options.max_edge_px)) {
      throw base::InputError(fmt::format(
          "{}: the chessboard is blurred: its edges are {:.1f} px wide, at most {:.1f} are allowed",
          name, edge_px, options.max_edge_px));
    }
  }
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& corner : corners) result.emplace_back(corner.x, corner.y);
  return result;
}

BoardSighting FindBoard(const BoardView& view, const ChessboardOptions& options) {
  const internal::SingleThread single_thread;
  BoardSighting sighting;
  sighting.name = view.name;
  sighting.left_px = FindChessboard(view.left, view.name + " (left)", options);
  sighting.right_px = FindChessboard(view.right, view.name + " (right)", options);
  // Start from the same corner in both: a few degrees of rotation do not exchange the board's ends.
  const Eigen::Vector2d left = sighting.left_px.back() - sighting.left_px.front();
  const Eigen::Vector2d right = sighting.right_px.back() - sighting.right_px.front();
  if (left.dot(right) < 0.0) std::ranges::reverse(sighting.right_px);
  sighting.plane_W = LaserPlane(view, options);
  return sighting;
}

base::Pose RightInLeft(const base::Pose& X_LBoard, const base::Pose& X_RBoard) {
  const Eigen::Matrix3d& R_l = X_LBoard.linear();
  const Eigen::Matrix3d& R_r = X_RBoard.linear();
  const Eigen::Matrix3d R = R_r * R_l.transpose();
  const Eigen::Vector3d T =
      X_LBoard.translation() - (R_l * R_r.transpose()) * X_RBoard.translation();
  return base::MakePose(R.transpose(), T);
}

CalibrationResult CalibrateStereo(std::span<const BoardSighting> boards, int width, int height,
                                  const ChessboardOptions& options) {
  const internal::SingleThread single_thread;
  CheckBoards(boards, options);
  const Corners corners = CornersOf(boards, options);
  const cv::Size size(width, height);
  CalibrationResult result;
  Lens lens = CalibrateLens(corners, size, result.camera_px);
  const base::Pose X_LR = CalibrateTurn(corners, lens, size, result.stereo_px);
  const std::vector<CornerOnPlane> pairs = CornersOnPlanes(boards, lens, X_LR, options);
  const base::Pose X_WL = Register(FirstRegistration(NormalsOf(lens, boards.size()), pairs), pairs);
  std::tie(result.scale, result.scale_error) = ScaleOf(X_WL, pairs, boards.size());
  result.views = static_cast<int>(boards.size());
  result.calibration = {.camera = CameraOf(lens, width, height),
                        .X_WL = X_WL,
                        .X_WR = X_WL * X_LR,
                        .reprojection_px = std::max(result.camera_px, result.stereo_px),
                        .registration_m = RootMeanSquare(pairs, X_WL)};
  result.triangulated_m =
      RootMeanSquare(TriangulatedOnPlanes(boards, result.calibration.camera, X_LR), X_WL);
  CheckResiduals(result, options);
  return result;
}

}  // namespace rangegrasp::stereo
