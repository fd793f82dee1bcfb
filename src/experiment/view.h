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

/// Views of a case: scenes in three dimensions and over time, and diagrams. All are in one frame W
/// [m], z up. A task fills in what it has.
struct View {
  using Color = Eigen::Vector4f;  ///< red, green, blue, opacity in 0..1

  /// Items with the same layer name are shown or hidden together.
  struct Points {
    std::string layer;
    geometry::Points points_W;
    Color color;
  };
  struct Surface {
    std::string layer;
    geometry::TriangleMesh mesh_W;
    Color color;
  };
  /// A surface with colored triangles. Each has its own picture; all are rotated together.
  struct Painted {
    std::string layer;
    geometry::TriangleMesh mesh_W;
    std::vector<std::uint8_t> paint;  ///< position in colors for each triangle
    std::vector<Color> colors;
  };
  /// A rigid body.
  struct Body {
    std::string name;
    std::string layer;
    geometry::TriangleMesh mesh_B;
    Color color;
    std::vector<base::Pose> X_WB;  ///< one per frame
  };
  struct Force {
    Eigen::Vector3d point_W;
    Eigen::Vector3d force_W;  ///< [N]
  };
  struct Frame {
    double time_s = 0.0;
    std::string moment;  ///< name of this moment; may be empty
    std::vector<Force> forces;
  };

  /// Diagrams that are shown together; one page is shown at a time.
  struct Page {
    std::string name;
    std::vector<draw::Panel> panels;
  };

  std::vector<Points> points;
  std::vector<Points> lines;  ///< each joins its points in order
  std::vector<Surface> surfaces;
  std::vector<Painted> painted;
  std::vector<Body> bodies;
  std::vector<Frame> frames;                         ///< in order of time; empty: nothing moves
  Eigen::Vector3d eye_W = Eigen::Vector3d::UnitX();  ///< position of the viewer
  Eigen::Vector3d target_W = Eigen::Vector3d::Zero();

  std::vector<draw::Panel> panels;  ///< always shown
  std::vector<Page> pages;          ///< shown one at a time

  bool Empty() const {
    return points.empty() && surfaces.empty() && painted.empty() && bodies.empty() &&
           panels.empty() && pages.empty();
  }
};

}  // namespace rangegrasp::experiment
