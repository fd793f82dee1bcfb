#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// An ideal pinhole camera: a point (x, y, z) of its frame is seen at center + focal (x / z, y /
/// z). Pixel coordinates (0, 0) are the center of the upper left pixel.
struct PinholeView {
  base::Pose X_WC;  ///< frame of a camera (base/frames.h)
  double focal_px = 0.0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
};

/// Quality of rendered pictures; absent values are as in the scene's file (offsamples, shadowsize).
struct RenderQuality {
  std::optional<int> samples;    ///< per pixel, for smooth edges; 0: none
  std::optional<int> shadow_px;  ///< edge of the shadow map
  bool fine_print = false;       ///< adds lists, bar codes and pictures to the labels of packages
};

/// Offscreen rendering through OSMesa, without a display or GPU.
class Renderer {
 public:
  /// @throws base::RunError if no offscreen context can be made.
  Renderer(const World& world, int width, int height, const RenderQuality& quality = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  /// @param world   the world that the renderer was made for.
  /// @param camera  name after the last '/', or a free view "x,y,z,lookx,looky,lookz" [m].
  /// @throws base::InputError naming the camera and those that exist.
  image::Image Render(World& world, const std::string& camera);
  /// The same from a pinhole view. Anything nearer than the clipping distance does not show.
  image::Image Render(const World& world, const PinholeView& view);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How a camera is placed so that its picture contains given points.
struct FramingOptions {
  int width_px = 960;
  int height_px = 720;
  double vertical_view_rad = 0.7;  ///< field of view between the upper and the lower edge
  double margin = 0.12;            ///< empty border at each edge, as a share of half the picture
  double min_distance_m = 0.35;    ///< to the nearest point; closer, the hand fills the view
};

/// Axes of an upright camera (no roll) that looks along a direction.
/// @throws std::invalid_argument for a vertical direction.
Eigen::Matrix3d LookingAlong(const Eigen::Vector3d& direction_W);

/// The nearest place of a camera with these axes from which all points are in the picture. In the
/// camera's axes, a camera at c sees a point q if |q_x - c_x| <= k (q_z - c_z), where k is the
/// tangent of half the angle of view. Hence c_x + k c_z <= min(q_x + k q_z) = A and c_x - k c_z >=
/// max(q_x - k q_z) = B. The largest c_z is (A - B) / (2 k), and then c_x = (A + B) / 2. The same
/// holds in y; the smaller c_z satisfies both.
/// @param points_W  at least one
/// @throws std::invalid_argument without points.
PinholeView FrameAll(std::span<const Eigen::Vector3d> points_W, const Eigen::Matrix3d& R_WC,
                     const FramingOptions& options);

/// The axes of the scene's camera "close", else of a view from the arm's right and slightly above.
Eigen::Matrix3d ViewAxes(const World& world);

/// Appends the corners of boxes around the hand's geoms (if any), or of the box around an object.
void AddHandCorners(const World& world, std::vector<Eigen::Vector3d>& corners_W);
void AddObjectCorners(const World& world, int object, std::vector<Eigen::Vector3d>& corners_W);

/// Pixel coordinates of a point in a view [px].
Eigen::Vector2d PixelOf(const PinholeView& view, const Eigen::Vector3d& point_W);

/// Draws an object on the shipped table in its most likely resting pose.
/// @param camera  a camera of the scene or a free view; empty: a close view
/// @throws base::InputError naming the file if it is not an object.
image::Image DrawObject(const sim::ObjectModel& object, const std::string& camera, int width,
                        int height);

/// Writes a world for MuJoCo's own programs: the model with its textures as FOLDER/model.mjb, the
/// state (mjSTATE_INTEGRATION, 64-bit floats) as FOLDER/state.bin.
/// @throws base::RunError if a file cannot be written.
void WriteModelAndState(const World& world, const std::filesystem::path& folder);

}  // namespace rangegrasp::sim
