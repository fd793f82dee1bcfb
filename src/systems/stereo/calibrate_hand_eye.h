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

/// A chessboard that rests on the table, as a camera on the arm sees it from one pose of the arm.
struct HandEyeView {
  base::Pose X_WH;  ///< the hand's root body, by the arm's joints
  /// The board's inner corners, row by row from the same one: options.columns * options.rows.
  std::vector<Eigen::Vector2d> corners_px;
};

struct HandEyeResult {
  base::Pose X_HC;      ///< the camera on the hand's root body
  base::Pose X_WBoard;  ///< the board, x along its rows
  double rms_px = 0.0;  ///< of the corners about where these two poses see them
  double rms_m = 0.0;   ///< of the board's places in W, by each view alone, about their mean
  /// Standard errors of X_HC (the jackknife over views; Efron 1982): what all corners of a view
  /// have in common, the arm's error, is in them.
  double shift_error_m = 0.0;
  double turn_error_rad = 0.0;
};

/// The board's inner corners in one picture, in an order that does not depend on how the camera is
/// turned: of both ends the board begins at the one whose first square of four corners is dark.
/// @throws base::InputError as FindChessboard; if columns and rows are both even or both odd.
std::vector<Eigen::Vector2d> FindBoardCorners(const image::Image& picture, const std::string& name,
                                              const ChessboardOptions& options);

/// Each view's own pose of the board (OpenCV's solvePnP) and the arm's poses give AX = XB, solved
/// by Park and Martin's method (OpenCV's calibrateHandEye); then the least squares of all corners
/// over both poses, by Gauss and Newton. O(corners) an iteration; the same input gives the same
/// result.
/// @throws base::InputError if there are fewer than options.min_views views, if the hand turned by
/// less than 10 deg between all of them, or if more than options.max_reprojection_px is left.
/// @throws std::invalid_argument if a view has another number of corners than the options.
HandEyeResult CalibrateHandEye(std::span<const HandEyeView> views, const Camera& camera,
                               const ChessboardOptions& options);

/// What a calibration starts from: the lens, the place of the camera in its head, and the hand's
/// pose at each picture.
struct HandEyeRecord {
  Camera camera;
  base::Pose X_SC = base::Pose::Identity();
  std::vector<base::Pose> X_WH;
};

/// YAML. @throws base::InputError naming file, line and key; base::RunError if it cannot be
/// written.
HandEyeRecord ReadHandEyeRecord(const std::filesystem::path& file);
void WriteHandEyeRecord(const HandEyeRecord& record, const std::filesystem::path& file);

}  // namespace rangegrasp::stereo
