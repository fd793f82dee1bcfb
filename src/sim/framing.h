#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim/render.h"

namespace rangegrasp::sim {

/// How a picture is taken of what has to be seen.
struct FramingOptions {
  int width_px = 960;
  int height_px = 720;
  double vertical_view_rad = 0.7;  ///< angle of view between the upper and the lower edge
  /// Of each edge that stays free, as a share of half the picture.
  double margin = 0.12;
  double min_distance_m = 0.35;  ///< of the camera from the nearest point: near by, all is hand
};

/// The axes of a camera's frame that looks along a direction, upright: no roll.
/// @throws std::invalid_argument for a direction along the vertical.
Eigen::Matrix3d LookingAlong(const Eigen::Vector3d& direction_W);

/// The nearest place of a camera with these axes from which all points are in the picture.
///
/// In the camera's axes a point q is in the picture of a camera at c if |q_x - c_x| <= k (q_z -
/// c_z) with k the tangent of half the angle of view; so c_x + k c_z <= min(q_x + k q_z) = A and
/// c_x - k c_z >= max(q_x - k q_z) = B: c_z = (A - B) / (2 k) at most, and then c_x = (A + B) / 2.
/// The same in y; the smaller c_z holds for both.
/// @param points_W  at least one
/// @throws std::invalid_argument without points.
PinholeView FrameAll(std::span<const Eigen::Vector3d> points_W, const Eigen::Matrix3d& R_WC,
                     const FramingOptions& options);

/// The axes from which a scene is shown: those of its camera "close" where it has one, else from
/// the arm's right and somewhat above.
Eigen::Matrix3d ViewAxes(const World& world);

/// The corners of boxes about all that is drawn of the hand, one a geom; none where the scene has
/// none.
void AddHandCorners(const World& world, std::vector<Eigen::Vector3d>& corners_W);
/// Those of the box about an object.
void AddObjectCorners(const World& world, int object, std::vector<Eigen::Vector3d>& corners_W);

/// Where a view shows a point [px]: x to the right, y down, from the middle of the upper left
/// pixel.
Eigen::Vector2d PixelOf(const PinholeView& view, const Eigen::Vector3d& point_W);

}  // namespace rangegrasp::sim
