#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// A camera without a lens's errors: a point (x, y, z) of its frame is seen at
/// center + focal (x / z, y / z); pixel (0, 0) is the middle of the upper left one.
struct PinholeView {
  base::Pose X_WC;  ///< frame of a camera (base/frames.h)
  double focal_px = 0.0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
};

/// How finely pictures are drawn, where not as the scene's file says (offsamples, shadowsize).
struct RenderQuality {
  std::optional<int> samples;    ///< of a pixel, for smooth edges; 0: none
  std::optional<int> shadow_px;  ///< edge of the map of shadows
  bool fine_print = false;       ///< lists, bar codes and pictures on packages, beside their labels
};

/// Offscreen pictures through OSMesa; no display, no GPU.
class Renderer {
 public:
  /// @throws base::RunError if no offscreen context can be made.
  Renderer(const World& world, int width, int height, const RenderQuality& quality = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  /// @param world   the one that the renderer was made for.
  /// @param camera  name after the last '/', or a free view "x,y,z,lookx,looky,lookz" [m].
  /// @throws base::InputError naming the camera and those that exist.
  image::Image Render(World& world, const std::string& camera);
  /// The same from a camera of its own. What is nearer than the clipping distance does not show.
  image::Image Render(const World& world, const PinholeView& view);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How a picture is taken of what has to be seen.
struct FramingOptions {
  int width_px = 960;
  int height_px = 720;
  double vertical_view_rad = 0.7;  ///< angle of view between the upper and the lower edge
  double margin = 0.12;            ///< free at each edge, as a share of half the picture
  double min_distance_m = 0.35;    ///< of the camera from the nearest point: near by, all is hand
};

/// The axes of a camera's frame that looks along a direction, upright: no roll.
/// @throws std::invalid_argument for a direction along the vertical.
Eigen::Matrix3d LookingAlong(const Eigen::Vector3d& direction_W);

/// The nearest place of a camera with these axes from which all points are in the picture. In the
/// camera's axes a point q is in the picture of a camera at c if |q_x - c_x| <= k (q_z -
/// c_z) with k the tangent of half the angle of view; so c_x + k c_z <= min(q_x + k q_z) = A and
/// c_x - k c_z >= max(q_x - k q_z) = B: c_z = (A - B) / (2 k) at most, and then c_x = (A + B) / 2.
/// The same in y; the smaller c_z holds for both.
/// @param points_W  at least one
/// @throws std::invalid_argument without points.
PinholeView FrameAll(std::span<const Eigen::Vector3d> points_W, const Eigen::Matrix3d& R_WC,
                     const FramingOptions& options);

/// The axes of the scene's camera "close", else from the arm's right and somewhat above.
Eigen::Matrix3d ViewAxes(const World& world);

/// The corners of boxes about the geoms of the hand (if any), or of the box about an object.
void AddHandCorners(const World& world, std::vector<Eigen::Vector3d>& corners_W);
void AddObjectCorners(const World& world, int object, std::vector<Eigen::Vector3d>& corners_W);

/// Where a view shows a point [px].
Eigen::Vector2d PixelOf(const PinholeView& view, const Eigen::Vector3d& point_W);

/// An object on the shipped table, in the pose that it rests in most likely.
/// @param camera  of the scene or a free view; empty: near by
/// @throws base::InputError naming the file if it is no object.
image::Image DrawObject(const sim::ObjectModel& object, const std::string& camera, int width,
                        int height);

}  // namespace rangegrasp::sim
