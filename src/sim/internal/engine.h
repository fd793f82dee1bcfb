#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "geometry/shape.h"
#include "robot/mjcf/hand.h"
#include "sim/world.h"

namespace rangegrasp::sim::internal {

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;
using mjcf::DataPtr;
using mjcf::ModelPtr;

/// Runs engine code. Warnings are appended to `warnings` (may be null); an engine error becomes a
/// base::RunError. It leaves the call by longjmp, so `call` must not own anything that needs a
/// destructor while the engine runs. After an error the mjData concerned must only be deleted.
void CallEngine(std::vector<std::string>* warnings, const std::function<void()>& call);
DataPtr MakeData(const mjModel* model);    ///< no kinematics yet. @throws base::RunError
DataPtr DataAtZero(const mjModel* model);  ///< with kinematics and centers of mass

using mjcf::BodyPose;
using mjcf::Collides;
using mjcf::Find;
using mjcf::GeomPose;
using mjcf::InSubtree;
using mjcf::NumericOf;
using mjcf::SitePose;
using mjcf::Suffix;
using mjcf::TryFind;
using mjcf::TupleOf;
using mjcf::Vec3;

/// Sets the positions of hinges and slides; the caller updates the kinematics.
void SetJoints(const mjModel* model, mjData* data, const std::vector<int>& joints,
               const double* positions);
/// Jacobian of a point that moves with a body, for some hinges and slides: p_W' = J q'.
Eigen::Matrix3Xd JacobianOf(const mjModel* model, const mjData* data,
                            const std::vector<int>& joints, int body,
                            const Eigen::Vector3d& point_W);

/// Center of mass in W of a root body and its subtree.
Eigen::Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root);

/// Colors of a model's geoms. Textures are read once.
class ColorsOfGeoms {
 public:
  explicit ColorsOfGeoms(const mjModel* model) : model_(model) {}

  /// Red, green, blue, opacity, 0..1; mean color for a textured geom.
  Eigen::Vector4f Of(int geom);
  /// The image of a 2-D texture.
  std::shared_ptr<const geometry::Print> Print(int texture);

 private:
  const mjModel* model_;
  std::map<int, Eigen::Vector3f> means_;  // by texture
  std::map<int, std::shared_ptr<const geometry::Print>> prints_;
};

/// Whether the engine's viewers show a geom: groups 0 to 2, not transparent.
bool Visible(const mjModel* model, int geom);
/// The 2-D texture of a geom that is a mesh with texture coordinates; -1 for none.
int TextureOf(const mjModel* model, int geom);
/// The surface of a geom in its frame; a plane is cut at its size, or at 10 m if infinite.
geometry::TriangleMesh GeomSurface(const mjModel* model, int geom, int segments);
/// Vertices in W of the surfaces of all geoms that take part in collisions.
geometry::Points CollisionVertices(const mjModel* model, const mjData* data, int segments);
/// Reach of a geom along a unit direction [m].
double ReachOfGeom(const mjModel* model, const mjData* data, int geom,
                   const Eigen::Vector3d& direction_W);

/// Smallest distance between two geoms [m], where b may be a plane; negative if they overlap, at
/// most limit_m.
double GeomDistance(const mjModel* model, mjData* data, int a, int b, double limit_m);

/// Visible geoms of a root body's subtree in W, with the first texture among them.
VisualMesh VisualOfTree(const mjModel* model, const mjData* data, int root, ColorsOfGeoms& colors);
/// Visible geoms of the body that holds the site "container". Its surface comes from the custom
/// numerics "container_albedo" and "container_gloss", else it is that of the table's blue laminate.
VisualMesh VisualOfContainer(const mjModel* model, const mjData* data, ColorsOfGeoms& colors);
/// Visible geoms of everything except objects (trees with a free joint), the container and the body
/// that holds the site "scanner". Surface: "scene_albedo" and "scene_gloss", else as above.
VisualMesh VisualOfScene(const mjModel* model, const mjData* data, ColorsOfGeoms& colors);

}  // namespace rangegrasp::sim::internal
