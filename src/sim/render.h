#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "image/image.h"
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

/// Offscreen pictures through OSMesa; no display, no GPU.
class Renderer {
 public:
  /// @throws core::RunError if no offscreen context can be made.
  Renderer(const World& world, int width, int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  /// @param world   the one that the renderer was made for.
  /// @param camera  name after the last '/', or a free view "x,y,z,lookx,looky,lookz" [m].
  /// @throws core::InputError naming the camera and those that exist.
  image::Image Render(World& world, const std::string& camera, const Overlay& overlay = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::sim
