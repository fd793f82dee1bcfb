#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"
#include "robot/mjcf/hand.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sim::internal {

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

/// Runs engine code with its log going to us: warnings are appended to `warnings` (may be null), an
/// engine error ends the call and becomes a base::RunError with the engine's text. The engine asks
/// error handlers to longjmp: `call` must not own anything that needs a destructor while the engine
/// runs, and after an error the mjData concerned must only be deleted.
void CallEngine(std::vector<std::string>* warnings, const std::function<void()>& call);
/// The state of a model as its file has it; no kinematics yet.
/// @throws base::RunError
DataPtr MakeData(const mjModel* model);
/// The same with the kinematics and centers of mass.
DataPtr DataAtZero(const mjModel* model);

using mjcf::Find;
using mjcf::InSubtree;
using mjcf::NumericOf;
using mjcf::Suffix;
using mjcf::TryFind;
using mjcf::TupleOf;

/// What the engine's arrays hold, as Eigen sees it.
inline Eigen::Map<const Eigen::Vector3d> Vec3(const mjtNum* p) {
  return Eigen::Map<const Eigen::Vector3d>(p);
}
inline base::Pose PoseOf(const mjtNum* position, const mjtNum* rotation) {
  return base::MakePose(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation),
                        Vec3(position));
}

/// Poses in W as of the last kinematics.
inline base::Pose BodyPose(const mjData* data, int body) {
  return PoseOf(data->xpos + 3 * body, data->xmat + 9 * body);
}
inline base::Pose GeomPose(const mjData* data, int geom) {
  return PoseOf(data->geom_xpos + 3 * geom, data->geom_xmat + 9 * geom);
}
inline base::Pose SitePose(const mjData* data, int site) {
  return PoseOf(data->site_xpos + 3 * site, data->site_xmat + 9 * site);
}

/// Center of mass in W of a root body and all below it.
Eigen::Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root);

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
