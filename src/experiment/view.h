#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "base/draw/plot.h"
#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::experiment {

/// What a person may look at of a case, in three dimensions and over time, or as diagrams. All in
/// one frame W [m], z up. A task fills in what it has.
struct View {
  using Color = Eigen::Vector4f;  ///< red, green, blue, opacity in 0..1

  /// What is shown or hidden together, by its name.
  struct Points {
    std::string layer;
    geometry::Points points_W;
    Color color;
  };
  struct Line {
    std::string layer;
    geometry::Points points_W;  ///< joined in order
    Color color;
  };
  struct Surface {
    std::string layer;
    geometry::TriangleMesh mesh_W;
    Color color;
  };
  /// A surface whose triangles have colors: a picture of its own; all are turned as one.
  struct Painted {
    std::string layer;
    geometry::TriangleMesh mesh_W;
    std::vector<std::uint8_t> paint;  ///< of each triangle, its position in colors
    std::vector<Color> colors;
  };
  /// What moves as one.
  struct Body {
    std::string name;
    std::string layer;
    geometry::TriangleMesh mesh_B;
    Color color;
    std::vector<base::Pose> X_WB;  ///< one a frame
  };
  struct Force {
    Eigen::Vector3d point_W;
    Eigen::Vector3d force_W;  ///< [N]
  };
  struct Frame {
    double time_s = 0.0;
    std::string moment;  ///< what it is called; may be empty
    std::vector<Force> forces;
  };

  /// Diagrams that are shown together, one such page at a time.
  struct Page {
    std::string name;
    std::vector<draw::Panel> panels;
  };

  std::vector<Points> points;
  std::vector<Line> lines;
  std::vector<Surface> surfaces;
  std::vector<Painted> painted;
  std::vector<Body> bodies;
  std::vector<Frame> frames;                         ///< in the order of time; empty: nothing moves
  Eigen::Vector3d eye_W = Eigen::Vector3d::UnitX();  ///< where it is looked at from
  Eigen::Vector3d target_W = Eigen::Vector3d::Zero();

  std::vector<draw::Panel> panels;  ///< always shown
  std::vector<Page> pages;          ///< leafed through

  bool Empty() const {
    return points.empty() && surfaces.empty() && painted.empty() && bodies.empty() &&
           panels.empty() && pages.empty();
  }
};

}  // namespace rangegrasp::experiment
