#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/mesh.h"
#include "geometry/ray_caster.h"

struct mjModel_;
struct mjData_;

namespace rangegrasp::sim {

/// An object to put into a scene: its MJCF (`models/objects/<name>/<name>.xml`).
struct ObjectModel {
  std::string name;
  std::filesystem::path mjcf;
};

/// Friction of a pair of surfaces: static and kinetic.
struct FrictionPair {
  double static_mu = 0.6, kinetic_mu = 0.5;
};
/// How the glove's friction is chosen from a surface's known range (sim/surfaces.h).
enum class FrictionChoice { kDrawn, kMiddle, kLow, kHigh, kKinetic };
constexpr std::array<std::string_view, 5> WordsOf(FrictionChoice) {
  return {"drawn", "middle", "low", "high", "kinetic"};
}
/// Physics options that an experiment may set.
struct PhysicsOptions {
  double timestep_s = 0.002;  ///< 1 and 0.5 ms give the same creep within 1 %, 4 ms does not
  FrictionChoice friction = FrictionChoice::kDrawn;
  std::optional<double> glove_friction;   ///< both coefficients on everything (for self-tests)
  std::optional<double> box_wall_m = {};  ///< inner height of the box; if absent, as in the scene
  int min_noslip = 0;  ///< at least so many iterations against creep, even if the scene has fewer
};

/// How a surface reflects a red laser line (635 nm).
struct OpticalSurface {
  double albedo = 0.7;   ///< 0..1, diffuse
  double gloss = 0.0;    ///< 0..1, share of mirror-like reflection
  double clarity = 0.0;  ///< 0..1, 1 = fully clear
};

/// The label of an open box that objects lie in; it is above the labels of all objects.
inline constexpr std::uint32_t kContainerLabel = 1000;

/// A surface in the world that a sensor may see, with a label that only the scorer may read.
struct VisualMesh {
  geometry::TriangleMesh mesh_W;
  OpticalSurface surface;
  geometry::MeshColors colors;  ///< a print's albedo takes precedence over the surface's
  std::uint32_t label = 0;      ///< 0: the scene (table, robot, ...); object i has label i + 1;
                                ///< an open box that they lie in has kContainerLabel
};

/// An open box of the scene. The box of the site "container" in its body is the interior.
struct Container {
  base::Pose X_WI;         ///< pose of the interior's center
  Eigen::Vector3d half_m;  ///< half of the interior's edges
};

/// Number of steps since the world was made that the engine's solver did not solve at first.
struct SolverCounts {
  int repeated = 0;  ///< repeated with dense matrices
  int unsolved = 0;  ///< not even solved with these
};

/// A saved state of a world, including the engine's internal state.
struct SavedWorld;

/// A compiled scene with objects, numbered in the given order: model and state of one simulated
/// world. Only one thread may use it at a time. Engine warnings are collected, never printed.
class World {
 public:
  /// Joins scene and objects (mjSpec) and compiles. All objects are parked; the arm is at its
  /// numeric "home", if any. An object's friction on the table is its surface's (sim/surfaces.h).
  /// @throws base::InputError with the file and the engine's message, or why it is not an object.
  World(const std::filesystem::path& scene_mjcf, const std::vector<ObjectModel>& objects,
        const PhysicsOptions& options);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  int objects() const;
  const std::string& object_name(int object) const;
  const std::string& object_surface(int object) const;  ///< its name (sim/surfaces.h)
  /// Friction of the glove on an object, or on the scene (-1). If it is to be drawn at random, it
  /// is the middle of its range until DrawFriction.
  const FrictionPair& glove_friction(int object) const;
  /// Draws the pairs of each object and of the scene from their ranges, if the options say so.
  void DrawFriction(base::Rng& rng);
  int object_body(int object) const;  ///< its root body in model()
  bool parked(int object) const;
  base::Pose ObjectPose(int object) const;  ///< X_WO of the object's root body
  Eigen::Vector3d ObjectCenterOfMass(int object) const;
  double ObjectMass(int object) const;
  /// Sets how much a geom's contacts yield, as a share of what the scene's file gives it.
  void ScaleSoftness(int geom, double share);
  double ObjectTop(int object) const;     ///< highest point of its collision geometry [m]
  double ObjectBottom(int object) const;  ///< lowest point of it [m]
  double ObjectSpeed(int object) const;   ///< |v| + radius |w| [m/s]
  Eigen::AlignedBox3d ObjectBounds(int object) const;  ///< of its collision geometry in W [m]
  /// Smallest distance of an object's collision geometry [m] to another object, to the robot (all
  /// that moves and is not an object), or to everything fixed. Negative if they overlap, at most
  /// limit_m.
  double ObjectDistance(int object, int other, double limit_m) const;
  double RobotDistance(int object, double limit_m) const;
  double SceneDistance(int object, double limit_m) const;
  std::optional<Container> container() const;
  void PlaceObject(int object, const base::Pose& X_WO);  ///< at rest
  void ParkObject(int object);  ///< moves it out of sight and reach, as before it was placed
  std::shared_ptr<const SavedWorld> Save() const;
  void Restore(const SavedWorld& saved);  ///< @param saved  of this world
  /// Whether a point is over a table: the engine's planes are infinite whatever their size. True in
  /// a scene without a bounded plane.
  bool OverTable(const Eigen::Vector3d& point_W) const;
  void SetArm(const Eigen::VectorXd& q);  ///< joint positions and servo targets
  Eigen::VectorXd ArmPositions() const;

  double time_s() const;
  void Refresh();  ///< updates the kinematics at the present positions; nothing moves
  /// One time step. It is repeated with dense matrices if the engine's Newton solver has not
  /// converged: such a step throws objects through the table at 400 rad/s. Both cases are counted.
  /// @throws base::RunError on an engine error.
  void Step();
  /// Steps until all unparked objects rest (slower than rest_speed for rest_time). Returns false
  /// after limit_s, or once an object has fallen more than a metre below the table.
  bool Settle(double limit_s = 5.0, double rest_speed_m_s = 0.002, double rest_time_s = 0.2);

  /// Steps as coarsely as falling objects allow, or as the scene and the options specify. Coarse:
  /// steps of 4 ms, no noslip iterations against creep (they take four fifths of the time in which
  /// twelve objects fall), friction as stiff as contact (impratio 1), and the robot may sleep if
  /// nothing touches it. Coulomb friction stays. Back in the scene's own steps, all wake and come
  /// to rest again.
  void StepCoarsely(bool coarsely);

  /// Visual geometry in W with its labels, without parked objects.
  std::vector<VisualMesh> VisualMeshes() const;
  base::Pose SitePose(const std::string& site) const;  ///< by its name after the last '/'

  const mjModel_* model() const;  ///< for the module's own files and tests
  mjModel_* model();
  mjData_* data();
  const mjData_* data() const;
  std::string Warnings() const;  ///< of the engine, each kind once
  int WarningCount() const;      ///< while stepping
  const SolverCounts& solver_counts() const;
  const PhysicsOptions& physics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string EngineVersion();  ///< "4.0.0"

/// An object's name in tables: the custom text "title" of its MJCF, else its own name.
/// @throws base::InputError naming the file if it cannot be parsed.
std::string ObjectTitle(const ObjectModel& object);

}  // namespace rangegrasp::sim
