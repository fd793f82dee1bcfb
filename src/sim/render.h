#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// Coloured points and lines drawn into a picture.
struct Overlay {
  struct Dot {
    Eigen::Vector3d p_W;
    Eigen::Vector4f rgba;
    double radius_m;
  };
  struct Segment {
    Eigen::Vector3d a_W, b_W;
    Eigen::Vector4f rgba;
    double radius_m;
  };
  std::vector<Dot> dots;
  std::vector<Segment> segments;
};

/// A camera without a lens's errors: where it stands, and where it images what is ahead.
/// A point (x, y, z) of its frame is seen at (center + focal (x / z, y / z)); pixel (0, 0) is the
/// middle of the upper left one.
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
  image::Image Render(World& world, const std::string& camera, const Overlay& overlay = {});
  /// The same from a camera that the scene need not have. What is nearer than the scene's clipping
  /// distance does not show.
  image::Image Render(const World& world, const PinholeView& view);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::sim
