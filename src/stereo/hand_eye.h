#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/frames.h"
#include "stereo/calibrate.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo {

/// A chessboard that rests on the table, as a camera on the arm sees it from one pose of the arm.
struct HandEyeView {
  core::Pose X_WH;  ///< the hand's root body, by the arm's joints
  /// The board's inner corners, row by row from the same one: options.columns * options.rows.
  std::vector<Eigen::Vector2d> corners_px;
};

struct HandEyeResult {
  core::Pose X_HC;      ///< the camera on the hand's root body
  core::Pose X_WBoard;  ///< the board, x along its rows
  double rms_px = 0.0;  ///< of the corners about where these two poses see them
  double rms_m = 0.0;   ///< of the board's places in W, by each view alone, about their mean
};

/// Where a camera sits on the hand: each view's own pose of the board (OpenCV's solvePnP) and the
/// arm's poses give AX = XB, solved by Park and Martin's method (OpenCV's calibrateHandEye); then
/// the least squares of all corners over both poses, by Gauss and Newton, of which rms_px is what
/// is left. O(corners) an iteration; the same input gives the same result.
/// @throws core::InputError if there are fewer than options.min_views views, if the hand turned by
/// less than 10 deg between all of them (the place along the axis that it turned about stays open),
/// or if more than options.max_reprojection_px is left: a board that was moved, another camera.
/// @throws std::invalid_argument if a view has another number of corners than the options.
HandEyeResult CalibrateHandEye(std::span<const HandEyeView> views, const Camera& camera,
                               const ChessboardOptions& options);

}  // namespace rangegrasp::stereo
