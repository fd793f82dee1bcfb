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

/// A chessboard, its inner corners counted, and what a calibration with it must reach.
struct ChessboardOptions {
  int columns = 9;  ///< inner corners along a row; one of both numbers odd and one even: the
  int rows = 6;     ///< board's ends differ
  double square_m = 0.025;
  double max_edge_px = 3.0;          ///< width of an edge's image, 10 to 90 %; blurred if more
  double max_reprojection_px = 0.3;  ///< root mean square
  double max_registration_m = 0.0015;
  double max_scale_error = 0.005;  ///< of its squares, against the laser's planes: 3 mm at 0.6 m
  int min_views = 6;
  double min_spread_rad = 0.1;  ///< of the boards' normals, in their narrowest direction
  double laser_band_m = 0.004;  ///< within which the laser's points are the board's plane at first
};

/// The corners on the board itself, row by row; z to the viewer who sees them in pictures' order.
std::vector<Eigen::Vector3d> CornersOfBoard(const ChessboardOptions& options);

/// One place of the board: both pictures of it, and what the laser measured there.
struct BoardView {
  std::string name;  ///< what errors call it
  image::Image left;
  image::Image right;
  geometry::Points laser_W;        ///< in the arm's frame; a few may be mixed ones at its edge
  Eigen::Vector3d laser_origin_W;  ///< where the laser stood
};

/// What is found of it: the board's corners in both pictures, row by row from the same one, and its
/// plane, whose normal points to the laser.
struct BoardSighting {
  std::string name;
  std::vector<Eigen::Vector2d> left_px;
  std::vector<Eigen::Vector2d> right_px;
  geometry::Plane plane_W;
};

/// A board's inner corners in a picture, to a fraction of a pixel: row by row from the same one.
/// @param name  what errors call the picture.
/// @throws base::InputError if there is no such board, or it is blurred.
std::vector<Eigen::Vector2d> FindChessboard(const image::Image& picture, const std::string& name,
                                            const ChessboardOptions& options);

/// Finds the board's corners and its plane.
/// @throws base::InputError as FindChessboard, or if the laser did not measure the board.
BoardSighting FindBoard(const BoardView& view, const ChessboardOptions& options);

/// Equations 5.13 and 5.14: R = R_r R_l^T and T = T_l - R_l R_r^T T_r, where R_l, T_l and R_r, T_r
/// take the board's points into the left and the right camera's frame: the pose of the right camera
/// in the left one's frame is (R^T, T).
base::Pose RightInLeft(const base::Pose& X_LBoard, const base::Pose& X_RBoard);

struct CalibrationResult {
  StereoCalibration calibration;
  double camera_px = 0.0;       ///< residual of the lens: each picture with a pose of its own
  double stereo_px = 0.0;       ///< residual with one turn between all pairs
  double registration_m = 0.0;  ///< of the corners, as one camera sees them, to the laser's planes
  double triangulated_m = 0.0;  ///< of the corners, as the pair triangulates them, to these planes
  double scale = 1.0;           ///< of all lengths, with which the planes would agree best
  double scale_error = 0.0;     ///< its standard error
  int views = 0;
};

/// One lens from all pictures (5.10 to 5.12, without r^6), the turn between left and right from the
/// pairs (5.13, 5.14, then the least squares of all corners), and the place of both in the arm's
/// frame: the pose that brings the corners that the camera sees nearest to the boards' planes,
/// which the laser measured (Zhang and Pless 2004, "Extrinsic calibration of a camera and laser
/// range finder"). O(corners) an iteration; the same input gives the same result.
/// @throws base::InputError if the boards are too few or too alike, or a residual is too large.
/// @throws std::invalid_argument if a sighting has another number of corners than the options.
CalibrationResult CalibrateStereo(std::span<const BoardSighting> boards, int width, int height,
                                  const ChessboardOptions& options);

}  // namespace rangegrasp::stereo
