#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/image/image.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::draw {

/// Red, green, blue, opacity in 0..1.
using Color = Eigen::Vector4f;

/// A color for number i that is clearly different from those of neighboring numbers.
Color PaletteColor(std::size_t i);

/// Points, lines and triangles to be drawn, all in one frame [m].
struct Canvas {
  struct Dots {
    geometry::Points points;
    Color color;
    float size_px = 2.0F;
  };
  struct Line {
    geometry::Points points;  ///< joined in order
    Color color;
    float width_px = 2.0F;
  };
  struct Surface {
    geometry::TriangleMesh mesh;
    Color color;
  };
  std::vector<Dots> dots;
  std::vector<Line> lines;
  std::vector<Surface> surfaces;  ///< drawn in order after dots and lines; put translucent last
};

/// A pinhole camera.
struct View {
  Eigen::Vector3d eye;
  Eigen::Vector3d target;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  double field_of_view_rad = 0.6;  ///< vertical
};

/// Draws a canvas without display or GPU (OSMesa).
/// @throws as image::OffscreenContext.
image::Image Render(const Canvas& canvas, const View& view, int width, int height);

}  // namespace rangegrasp::draw
