#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <map>

#include "geometry/shape.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sim::internal {

/// Geoms in one color each.
class ColorsOfGeoms {
 public:
  explicit ColorsOfGeoms(const mjModel* model) : model_(model) {}

  /// Red, green, blue, opacity, 0..1; of what is printed on it, the mean.
  Eigen::Vector4f Of(int geom);

 private:
  const mjModel* model_;
  std::map<int, Eigen::Vector3f> prints_;  // by material
};

/// Whether the engine's viewers show a geom: groups 0 to 2, not transparent.
bool Visible(const mjModel* model, int geom);
/// Whether a geom takes part in collisions.
bool Collides(const mjModel* model, int geom);
/// The surface of a geom in the geom's frame; a plane is cut at its size, or at 10 m where it is
/// infinite.
geometry::TriangleMesh GeomSurface(const mjModel* model, int geom, int segments);
/// Highest point of a geom [m].
double ReachOfGeom(const mjModel* model, const mjData* data, int geom,
                   const Eigen::Vector3d& direction_W);

/// Least distance between two geoms, of which b may be a plane [m]; negative where they are inside
/// each other, limit_m where they are further apart.
double GeomDistance(const mjModel* model, mjData* data, int a, int b, double limit_m);

/// Visible geoms (groups 0 to 2, not transparent) below a root body, in W, with the first texture
/// that one of them has; what has another one has no print.
VisualMesh VisualOfTree(const mjModel* model, const mjData* data, int root);
/// The body that holds the site "container"; -1 if there is none.
int ContainerBody(const mjModel* model);
/// Its visible geoms. Surface: custom numerics "container_albedo" and "container_gloss", else that
/// of the blue laminate.
VisualMesh VisualOfContainer(const mjModel* model, const mjData* data);
/// Visible geoms of everything that is no object (no tree with a free joint), without the
/// container and the body that holds the site "scanner". Surface: custom numerics "scene_albedo"
/// and "scene_gloss", else that of the blue laminate.
VisualMesh VisualOfScene(const mjModel* model, const mjData* data);

}  // namespace rangegrasp::sim::internal
