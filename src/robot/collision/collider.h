#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/plane.h"
#include "geometry/shape.h"
#include "robot/robot.h"

namespace fcl {
template <typename S>
class CollisionGeometry;
}

namespace rangegrasp::collision {

/// How a shape is converted to a solid.
struct SolidOptions {
  double margin_m = 0.0;  ///< the shape is grown by this (geometry::Grown)
  /// 0: spheres, capsules, boxes ... are exact, and objects wholly inside them are found. From 3:
  /// facets with this many sides in a tree of oriented boxes, as much outside a finger's surface as
  /// inside it; objects wholly inside are not found.
  int sides = 0;
};

/// A body for collision checks. Meshes and convex pieces are surfaces in a tree of oriented boxes
/// (Gottschalk, Lin and Manocha 1996; FCL's BVHModel): they collide where surfaces cross. Copies
/// share the tree.
class Solid {
 public:
  explicit Solid(geometry::Shape shape, const SolidOptions& options = {});
  /// A mesh in its own frame S; one without triangles collides with nothing.
  explicit Solid(geometry::TriangleMesh mesh);

  bool IsEmpty() const { return geometry_ == nullptr; }
  const base::Pose& X_BS() const { return shape_.X_BS; }  ///< in the body that carries it
  const geometry::Points& Vertices() const { return shape_.mesh.vertices; }  ///< of meshes, in S
  /// Its axis-aligned bounding box; for a mesh, the box around its own rotated box.
  Eigen::AlignedBox3d BoxAt(const base::Pose& X_WS) const;
  double LowestAt(const base::Pose& X_WS) const;  ///< lowest z, exact
  /// Whether the two touch: the narrow phase, without a test of the boxes.
  bool Touches(const base::Pose& X_WS, const Solid& other, const base::Pose& X_WOther) const;

 private:
  geometry::Shape shape_;    // grown; a mesh if it is faceted
  Eigen::AlignedBox3d box_;  // of a mesh, in S
  std::shared_ptr<const fcl::CollisionGeometry<double>> geometry_;
};

/// A solid at a pose. Keeps a pointer to the solid.
struct PlacedSolid {
  const Solid* solid;
  base::Pose X_WS;
  Eigen::AlignedBox3d box_W;
};
/// @param X_WB  pose of the body that carries the solid
PlacedSolid Place(const Solid& solid, const base::Pose& X_WB);

/// Whether two solids touch; tests their boxes first.
bool Hit(const PlacedSolid& a, const PlacedSolid& b);

/// The shapes of a hand as solids, which only move between its states. Keeps a reference to the
/// hand.
class HandSolids {
 public:
  HandSolids(const robot::HandModel& hand, const SolidOptions& options);

  /// All solids, with the hand's root body at X_WH, in one of its states.
  std::vector<PlacedSolid> At(const base::Pose& X_WH, std::size_t state) const;

 private:
  const robot::HandModel* hand_;
  std::vector<Solid> solids_;
};

struct HandColliderOptions {
  double object_clearance_m = 0.002;  ///< between the hand and other objects
  double table_clearance_m = 0.004;   ///< of the hand's lowest point above the table
  int sides = 12;                     ///< of the hand's round shapes, see SolidOptions
};

/// Checks the hand in any of its states against surfaces and the table, for hundreds of grasps. C
/// is any one frame. An obstacle wholly inside a shape of the hand is found. A shape of the hand
/// wholly inside an obstacle is not, but the adjacent shapes that lead out of the obstacle are.
class HandCollider {
 public:
  /// Keeps a reference to the hand.
  /// @param obstacles_C  must keep object_clearance_m to the hand: the hand is grown by it
  /// @param own_C        the object to be grasped: must not be touched before the hand closes
  /// @param table_C      normal away from the table; the hand stays table_clearance_m above
  HandCollider(const robot::HandModel& hand, std::span<const geometry::TriangleMesh> obstacles_C,
               const geometry::TriangleMesh& own_C, const geometry::Plane& table_C,
               const HandColliderOptions& options);

  void SetOwn(const geometry::TriangleMesh& own_C) { own_ = Solid(own_C); }

  bool HitsObstacle(const base::Pose& X_CH, std::size_t state) const;
  bool HitsOwn(const base::Pose& X_CH, std::size_t state) const;
  bool HitsTable(const base::Pose& X_CH, std::size_t state) const;
  /// Height of the hand's lowest point above the table [m]; exact.
  double TableDistance(const base::Pose& X_CH, std::size_t state) const;

 private:
  bool Swallows(const base::Pose& X_CH, std::size_t state, const std::vector<PlacedSolid>& grown,
                const PlacedSolid& obstacle) const;

  const robot::HandModel* hand_;
  HandColliderOptions options_;
  geometry::Plane table_C_;
  HandSolids grown_;
  HandSolids bare_;
  std::vector<Solid> obstacles_;
  Solid own_;
};

/// What the robot may touch in a stage of its motion, and the state of its hand there.
struct Contacts {
  enum class Target {
    kObstacle,      ///< not to be touched
    kHandMayTouch,  ///< between the hand's fingers: the arm must not touch it
    kHeld,          ///< in the hand
    kGone
  };
  std::size_t hand_state = 0;  ///< of HandModel::states
  bool hand_margin = true;
  Target target = Target::kObstacle;
  base::Pose X_HT = base::Pose::Identity();  ///< kHeld: the target's frame in the hand
  std::vector<char> held_ignores;            ///< kHeld: per obstacle; empty: none is ignored
  /// kHeld: hand and target keep cell_margin_m to the work cell, and the target may reach
  /// held_below_m lower than its perceived surface.
  bool cell_margin = false;
  double held_below_m = 0.0;
  bool may_touch_table = false;  ///< the hand and the held object may; the arm must not
};

struct Touch {
  enum class Other { kTable, kRobot, kWorkcell, kObstacle, kTarget };
  std::size_t part = 0;  ///< index in Robot::links(); then the hand, then the held object
  Other other = Other::kTable;
  std::size_t index = 0;  ///< kRobot: like `part`; else of the work cell's shapes or the obstacles
};

/// The robot, the held object, the work cell and the perceived surfaces, for checks along motions.
/// All shapes are exact (SolidOptions::sides 0). Not thread-safe.
class RobotCollider {
 public:
  /// Keeps a reference to the robot.
  /// @param margin_m  grows the arm always, and the hand if Contacts::hand_margin is set
  /// @param cell_margin_m  grows the work cell if Contacts::cell_margin is set
  RobotCollider(const robot::Robot& robot, double margin_m, double cell_margin_m = 0.0);
  RobotCollider(const RobotCollider&) = delete;
  RobotCollider& operator=(const RobotCollider&) = delete;

  /// Sets the scene in W; the table is the plane z = table_z_m.
  void SetScene(double table_z_m, std::span<const geometry::TriangleMesh> obstacles_W,
                const geometry::TriangleMesh& target_W);

  /// Whether the robot touches something that it must not.
  /// @param links_W  robot::Robot::LinkPoses at the joint positions in question
  bool Hits(const std::vector<base::Pose>& links_W, const Contacts& contacts) {
    return FirstTouch(links_W, contacts).has_value();
  }
  std::optional<Touch> FirstTouch(const std::vector<base::Pose>& links_W, const Contacts& contacts);
  /// A contact as text: "arm/link6 and hand", "hand and the table", with the names of the MJCF.
  std::string TextOf(const Touch& touch) const;

  /// Per obstacle: whether the held target touches it with the hand at X_WH.
  std::vector<char> TouchedByTarget(const base::Pose& X_WH, const base::Pose& X_HT) const;
  double LowestOfHand(const base::Pose& X_WH, std::size_t state) const;  ///< lowest z, no margin

 private:
  void PlaceRobot(const std::vector<base::Pose>& links_W, const base::Pose& X_WH,
                  const Contacts& contacts);
  bool IsBelowTable(const PlacedSolid& part) const;
  std::optional<Touch> TouchOfTable(const Contacts& contacts) const;
  std::optional<Touch> TouchOfItself() const;
  std::optional<Touch> TouchOfScene(const Contacts& contacts) const;
  std::optional<Touch> TouchOfHeld(const base::Pose& X_WH, const Contacts& contacts) const;
  std::optional<Touch> HeldInWorkcell(const base::Pose& X_WT, const Contacts& contacts) const;
  std::string NameOfPart(std::size_t part) const;

  const robot::Robot& robot_;
  HandSolids grown_hand_;
  HandSolids bare_hand_;
  std::vector<std::vector<Solid>> links_;
  std::vector<bool> fixed_;  ///< per link: it does not move; false for the hand
  std::vector<Solid> workcell_solids_, grown_workcell_solids_;
  std::vector<PlacedSolid> workcell_, grown_workcell_;
  std::vector<Solid> obstacle_solids_;
  std::vector<PlacedSolid> obstacles_;
  Solid target_{geometry::TriangleMesh()};
  double table_z_m_ = 0.0;
  std::vector<std::vector<PlacedSolid>> placed_;  ///< links, then the hand, of the present check
};

}  // namespace rangegrasp::collision
