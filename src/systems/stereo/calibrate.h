#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "base/image/image.h"
#include "geometry/plane.h"
#include "geometry/point_cloud.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo {

/// A chessboard, given by its inner corners, and the required quality of a calibration with it.
struct ChessboardOptions {
  int columns = 9;  ///< inner corners along a row
  int rows = 6;     ///< rows of inner corners; one number odd and one even: the ends differ
  double square_m = 0.025;
  double max_edge_px = 3.0;          ///< width of an edge's image, 10 to 90 %; blurred if more
  double max_reprojection_px = 0.3;  ///< root mean square
  double max_registration_m = 0.0015;
  double max_scale_error = 0.005;  ///< of its squares, by the laser's planes: 3 mm at 0.6 m
  int min_views = 6;
  double min_spread_rad = 0.1;  ///< of the boards' normals, in their narrowest direction
  double laser_band_m = 0.004;  ///< of laser points about the board's plane in the first fit
};

/// The corners on the board itself, row by row; z to the viewer who sees them in pictures' order.
std::vector<Eigen::Vector3d> CornersOfBoard(const ChessboardOptions& options);

/// One pose of the board: both pictures of it, and the laser's measurement of it.
struct BoardView {
  std::string name;  ///< its name in errors
  image::Image left;
  image::Image right;
  geometry::Points laser_W;        ///< in the arm's frame; may have a few mixed points at its edge
  Eigen::Vector3d laser_origin_W;  ///< position of the laser
};

/// Detection of the board: its corners in both pictures, row by row from the same corner, and its
/// plane, whose normal points to the laser.
struct BoardSighting {
  std::string name;
  std::vector<Eigen::Vector2d> left_px;
  std::vector<Eigen::Vector2d> right_px;
  geometry::Plane plane_W;
};

/// A board's inner corners in a picture, with subpixel accuracy, row by row.
/// @param name  the picture's name in errors.
/// @throws base::InputError if the board is not found, or is blurred.
std::vector<Eigen::Vector2d> FindChessboard(const image::Image& picture, const std::string& name,
                                            const ChessboardOptions& options);

/// @throws base::InputError like FindChessboard, or if the laser did not measure the board.
BoardSighting FindBoard(const BoardView& view, const ChessboardOptions& options);

/// Equations 5.13 and 5.14: R = R_r R_l^T and T = T_l - R_l R_r^T T_r, where R_l, T_l and R_r, T_r
/// transform the board's points to the left and the right camera's frame: the pose of the right
/// camera in the left one's frame is (R^T, T).
base::Pose RightInLeft(const base::Pose& X_LBoard, const base::Pose& X_RBoard);

struct CalibrationResult {
  StereoCalibration calibration;  ///< its registration_m: corners to the laser's planes, one camera
  double camera_px = 0.0;         ///< residual of the lens, with a separate pose for each picture
  double stereo_px = 0.0;         ///< residual with the same relative pose for all pairs
  double triangulated_m = 0.0;    ///< distance of corners to the laser's planes, triangulated
  double scale = 1.0;             ///< factor of all lengths that fits the planes best
  double scale_error = 0.0;       ///< its standard error
  int views = 0;
};

/// Calibrates one lens from all pictures (5.10 to 5.12, without r^6), the relative pose of left and
/// right from the pairs (5.13, 5.14, then least squares over all corners), and the pose of both in
/// the arm's frame, which minimizes the distances of the corners from the boards' planes that the
/// laser measured (Zhang and Pless 2004, "Extrinsic calibration of a camera and laser range
/// finder"). O(corners) per iteration; the same input gives the same result.
/// @throws base::InputError if the boards are too few or too alike, or a residual is too large.
/// @throws std::invalid_argument if a sighting has another number of corners than the options.
CalibrationResult CalibrateStereo(std::span<const BoardSighting> boards, int width, int height,
                                  const ChessboardOptions& options);

}  // namespace rangegrasp::stereo
