#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "stereo/calibrate.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo {

/// A chessboard on the table, seen by a camera on the arm from one pose of the arm.
struct HandEyeView {
  base::Pose X_WH;  ///< the hand's root body, from the arm's joints
  /// The board's inner corners, row by row from the same corner: options.columns * options.rows.
  std::vector<Eigen::Vector2d> corners_px;
};

struct HandEyeResult {
  base::Pose X_HC;      ///< the camera in the frame of the hand's root body
  base::Pose X_WBoard;  ///< the board, x along its rows
  double rms_px = 0.0;  ///< distance of the corners from their projections by these poses
  double rms_m = 0.0;   ///< of the board's positions by single views, relative to X_WBoard
  /// Standard errors of X_HC (jackknife over views; Efron 1982). They include the arm's error,
  /// which all corners of a view share.
  double shift_error_m = 0.0;
  double turn_error_rad = 0.0;
};

/// The board's inner corners in one picture, in an order that does not depend on the camera's
/// orientation: the first corner is at the end whose first square of four corners is dark.
/// @throws base::InputError like FindChessboard; if columns and rows are both even or both odd.
std::vector<Eigen::Vector2d> FindBoardCorners(const image::Image& picture, const std::string& name,
                                              const ChessboardOptions& options);

/// The board's pose in each view (OpenCV's solvePnP) and the arm's poses give AX = XB, which is
/// solved by Park and Martin's method (OpenCV's calibrateHandEye). Then Gauss-Newton minimizes the
/// errors of all corners over both poses. O(corners) per iteration; the same input gives the same
/// result.
/// @throws base::InputError if there are fewer than options.min_views views, if the hand turned by
/// less than 10 deg between all of them, or if the residual is above options.max_reprojection_px.
/// @throws std::invalid_argument if a view has another number of corners than the options.
HandEyeResult CalibrateHandEye(std::span<const HandEyeView> views, const Camera& camera,
                               const ChessboardOptions& options);

/// Input of a calibration: the lens, the pose of the camera in its head, and the hand's pose at
/// each picture.
struct HandEyeRecord {
  Camera camera;
  base::Pose X_SC = base::Pose::Identity();
  std::vector<base::Pose> X_WH;
};

/// YAML.
/// @throws base::InputError naming file, line and key; base::RunError if it cannot be written.
HandEyeRecord ReadHandEyeRecord(const std::filesystem::path& file);
void WriteHandEyeRecord(const HandEyeRecord& record, const std::filesystem::path& file);

}  // namespace rangegrasp::stereo
