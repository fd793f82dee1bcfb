#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "sim/visual_mesh.h"

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
/// Which friction the glove has on a surface, of the range that is known (sim/surfaces.h).
enum class FrictionChoice { kDrawn, kMiddle, kLow, kHigh, kKinetic };
constexpr std::array<std::string_view, 5> WordsOf(FrictionChoice) {
  return {"drawn", "middle", "low", "high", "kinetic"};
}
/// Options of the physics that an experiment may set.
struct PhysicsOptions {
  double timestep_s = 0.002;  ///< 1 and 0.5 ms creep the same within 1 %, 4 ms does not
  FrictionChoice friction = FrictionChoice::kDrawn;
  std::optional<double> glove_friction;   ///< both coefficients on everything (for self-tests)
  std::optional<double> box_wall_m = {};  ///< inner height of the box; absent: as the scene has it
};

/// An open box of the scene: the interior is the box of the site "container" in its body.
struct Container {
  base::Pose X_WI;         ///< of the interior's middle
  Eigen::Vector3d half_m;  ///< half of its edges
};

/// Steps since a world was made that the engine's solver did not solve at once.
struct SolverCounts {
  int repeated = 0;  ///< with dense matrices
  int unsolved = 0;  ///< not even with these
};

/// A state that a world can go back to, with all that the engine keeps of it.
struct SavedWorld;

/// A compiled scene with objects, numbered as given: model and state of one simulated world. One
/// thread at a time. Engine warnings are collected, never printed.
class World {
 public:
  /// Joins scene and objects (mjSpec) and compiles. All objects are parked; the arm stands in its
  /// numeric "home", if any. An object's friction on the table is its surface's (sim/surfaces.h).
  /// @throws base::InputError with the file and the engine's message, or why an object is none.
  World(const std::filesystem::path& scene_mjcf, const std::vector<ObjectModel>& objects,
        const PhysicsOptions& options);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  int objects() const;
  const std::string& object_name(int object) const;
  const std::string& object_surface(int object) const;  ///< its name (sim/surfaces.h)
  /// The glove on an object, or on the scene (-1). Where it is to be drawn, the middle of its range
  /// until DrawFriction.
  const FrictionPair& glove_friction(int object) const;
  /// Draws the pair of each object and of the scene from its range, where the options say so.
  void DrawFriction(base::Rng& rng);
  int object_body(int object) const;  ///< its root body in model()
  bool parked(int object) const;
  base::Pose ObjectPose(int object) const;  ///< X_WO of the object's root body
  Eigen::Vector3d ObjectCenterOfMass(int object) const;
  double ObjectMass(int object) const;
  double ObjectTop(int object) const;     ///< highest point of its collision geometry [m]
  double ObjectBottom(int object) const;  ///< and the lowest one
  double ObjectSpeed(int object) const;   ///< |v| + radius |w| [m/s]
  Eigen::AlignedBox3d ObjectBounds(int object) const;  ///< of its collision geometry in W [m]
  /// Least distance of an object's collision geometry [m] to another object, to the robot (what
  /// moves and is no object), or to all that is fixed: negative where they overlap, limit_m at
  /// most.
  double ObjectDistance(int object, int other, double limit_m) const;
  double RobotDistance(int object, double limit_m) const;
  double SceneDistance(int object, double limit_m) const;
  std::optional<Container> container() const;
  void PlaceObject(int object, const base::Pose& X_WO);  ///< at rest
  void ParkObject(int object);  ///< out of sight and reach, as before it was placed
  std::shared_ptr<const SavedWorld> Save() const;
  void Restore(const SavedWorld& saved);  ///< @param saved  of this world
  /// Whether a point is over a table: the engine's planes are infinite whatever their size. True in
  /// a scene without a bounded plane.
  bool OverTable(const Eigen::Vector3d& point_W) const;
  void SetArm(const Eigen::VectorXd& q);  ///< joint positions and servo targets
  Eigen::VectorXd ArmPositions() const;

  double time_s() const;
  void Refresh();  ///< kinematics of the present positions; nothing moves
  /// One time step; again with dense matrices where the engine's Newton solver has not converged,
  /// which throws things through the table at 400 rad/s. Both are counted.
  /// @throws base::RunError on an engine error.
  void Step();
  /// Steps until all unparked objects rest (slower than rest_speed for rest_time); false after
  /// limit_s, or once one fell more than a metre below the table.
  bool Settle(double limit_s = 5.0, double rest_speed_m_s = 0.002, double rest_time_s = 0.2);

  /// Steps as coarsely as falling things allow, or as the scene and the options have it. Coarsely:
  /// steps of 4 ms, no iterations against creep (noslip: four fifths of the time in which twelve
  /// objects fall), friction as stiff as contact (impratio 1), a robot that nothing touches may
  /// sleep. Coulomb friction stays. Back in the scene's own steps all wake and come to rest again.
  void StepCoarsely(bool coarsely);

  /// Visual geometry in W with its labels, parked objects left out.
  std::vector<VisualMesh> VisualMeshes() const;
  base::Pose SitePose(const std::string& site) const;  ///< by its name after the last '/'

  const mjModel_* model() const;  ///< for the module's own files and tests
  mjModel_* model();
  mjData_* data();
  const mjData_* data() const;
  std::string Warnings() const;  ///< of the engine, by kind
  int WarningCount() const;      ///< while stepping
  const SolverCounts& solver_counts() const;
  const PhysicsOptions& physics() const;

 private:
  // Of its collision geometry along a unit direction [m].
  double ObjectReach(int object, const Eigen::Vector3d& direction_W) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string EngineVersion();  ///< "4.0.0"

/// What an object is called in tables: the custom text "title" of its MJCF, else its name.
/// @throws base::InputError naming the file if it cannot be parsed.
std::string ObjectTitle(const ObjectModel& object);

}  // namespace rangegrasp::sim
