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

/// How a shape becomes a solid.
struct SolidOptions {
  double margin_m = 0.0;  ///< the shape is grown by it (geometry::Grown)
  /// 0: spheres, capsules, boxes ... are exact, and what lies wholly inside of them is found.
  /// From 3: facets with so many sides in a tree of oriented boxes, as much outside of a finger's
  /// surface as inside; what lies wholly inside is not found.
  int sides = 0;
};

/// A body for collision checks. Meshes and convex pieces are surfaces in a tree of oriented boxes
/// (Gottschalk, Lin and Manocha 1996; FCL's BVHModel): they are hit where surfaces cross. Copies
/// share the tree.
class Solid {
 public:
  explicit Solid(geometry::Shape shape, const SolidOptions& options = {});
  /// In its own frame S; one without triangles is hit by nothing.
  explicit Solid(geometry::TriangleMesh mesh);

  bool IsEmpty() const { return geometry_ == nullptr; }
  const base::Pose& X_BS() const { return shape_.X_BS; }  ///< in the body that carries it
  const geometry::Points& Vertices() const { return shape_.mesh.vertices; }  ///< of meshes, in S
  /// The axis-aligned box about it; of meshes, the one about their own turned box.
  Eigen::AlignedBox3d BoxAt(const base::Pose& X_WS) const;
  double LowestAt(const base::Pose& X_WS) const;  ///< z, exact
  /// Whether the two touch: the narrow phase, without a look at the boxes.
  bool Touches(const base::Pose& X_WS, const Solid& other, const base::Pose& X_WOther) const;

 private:
  geometry::Shape shape_;    // grown; a mesh where it is facets
  Eigen::AlignedBox3d box_;  // of a mesh, in S
  std::shared_ptr<const fcl::CollisionGeometry<double>> geometry_;
};

/// A solid in its place. Keeps a pointer to it.
struct PlacedSolid {
  const Solid* solid;
  base::Pose X_WS;
  Eigen::AlignedBox3d box_W;
};
/// @param X_WB  of the body that carries the solid
PlacedSolid Place(const Solid& solid, const base::Pose& X_WB);
/// The same for a solid that is not where its own X_BS says.
PlacedSolid PlaceAt(const Solid& solid, const base::Pose& X_WS);

/// Whether two solids touch: their boxes first.
bool Hit(const PlacedSolid& a, const PlacedSolid& b);

/// The shapes of a hand as solids, which only move from one of its states to the next. Keeps a
/// reference to the hand.
class HandSolids {
 public:
  /// @throws std::invalid_argument if the hand has no states, or they differ in their shapes.
  HandSolids(const robot::HandModel& hand, const SolidOptions& options);

  /// All of them with the hand's root body at X_WH, in one of its states.
  std::vector<PlacedSolid> At(const base::Pose& X_WH, std::size_t state) const;
  double LowestAt(const base::Pose& X_WH, std::size_t state) const;  ///< z

 private:
  const robot::HandModel* hand_;
  std::vector<Solid> solids_;
};

struct HandColliderOptions {
  double object_clearance_m = 0.002;  ///< between the hand and other objects
  double table_clearance_m = 0.004;   ///< of the hand's lowest point above the table
  /// Of the hand's round shapes, see SolidOptions. 0: exact.
  int sides = 12;
};

/// The hand in any of its states against surfaces and the table, for hundreds of grasps. C is any
/// one frame. An obstacle wholly inside a shape of the hand is found; a shape of the hand wholly
/// inside an obstacle is not, but the adjacent shapes that lead out of the obstacle are.
class HandCollider {
 public:
  /// Keeps a reference to the hand.
  /// @param obstacles_C  must keep object_clearance_m to the hand: its shapes are grown by that
  /// @param own_C        the object to be grasped: must not be touched before the hand closes
  /// @param table_C      normal away from the table; the hand stays table_clearance_m above
  /// @throws std::invalid_argument if the hand has no states, or they differ in their shapes.
  HandCollider(const robot::HandModel& hand, std::span<const geometry::TriangleMesh> obstacles_C,
               const geometry::TriangleMesh& own_C, const geometry::Plane& table_C,
               const HandColliderOptions& options);

  /// Another surface of the object to be grasped.
  void SetOwn(const geometry::TriangleMesh& own_C) { own_ = Solid(own_C); }

  bool HitsObstacle(const base::Pose& X_CH, std::size_t state) const;
  bool HitsOwn(const base::Pose& X_CH, std::size_t state) const;
  bool HitsTable(const base::Pose& X_CH, std::size_t state) const;
  /// The lowest point of the hand above the table [m]; exact.
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

/// What the robot may touch in a stage of its motion, and what its hand looks like there.
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
  base::Pose X_HT = base::Pose::Identity();  ///< kHeld: the frame of the target in the hand
  std::vector<char> held_ignores;            ///< kHeld: one an obstacle; empty: none is
  /// kHeld: hand and target keep cell_margin_m to the work cell, and the target may reach so much
  /// lower than what was seen of it.
  bool cell_margin = false;
  double held_below_m = 0.0;
  bool may_touch_table = false;  ///< the hand and what it holds; the arm must not
};

/// Two things that touch.
struct Touch {
  enum class Other { kTable, kRobot, kWorkcell, kObstacle, kTarget };
  std::size_t part = 0;  ///< position in Robot::links(); next the hand, then what it holds
  Other other = Other::kTable;
  std::size_t index = 0;  ///< kRobot: as `part`; of the work cell's shapes or the obstacles
};

/// The robot, what it holds, its work cell and what was perceived, for checks along motions. All
/// shapes are exact (SolidOptions::sides 0). Not thread-safe.
class RobotCollider {
 public:
  /// Keeps a reference to the robot.
  /// @param margin_m  grows about the arm always, about the hand where Contacts::hand_margin asks
  /// @param cell_margin_m  grows about the work cell where Contacts::cell_margin asks
  RobotCollider(const robot::Robot& robot, double margin_m, double cell_margin_m = 0.0);
  RobotCollider(const RobotCollider&) = delete;
  RobotCollider& operator=(const RobotCollider&) = delete;

  /// Takes a scene in W: the table is the plane z = table_z_m.
  void SetScene(double table_z_m, std::span<const geometry::TriangleMesh> obstacles_W,
                const geometry::TriangleMesh& target_W);

  /// Whether the robot touches something that it must not.
  /// @param links_W  robot::Robot::LinkPoses at the joint positions in question
  bool Hits(const std::vector<base::Pose>& links_W, const Contacts& contacts) {
    return FirstTouch(links_W, contacts).has_value();
  }
  /// What touches what: the first that is found.
  std::optional<Touch> FirstTouch(const std::vector<base::Pose>& links_W, const Contacts& contacts);
  /// The same for people: "arm/link6 and hand", "hand and the table", by the names of the MJCF.
  std::string TextOf(const Touch& touch) const;

  /// One an obstacle: does the held target touch it with the hand at X_WH?
  std::vector<char> TouchedByTarget(const base::Pose& X_WH, const base::Pose& X_HT) const;
  double LowestOfHand(const base::Pose& X_WH, std::size_t state) const;  ///< z, without margin

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
  std::vector<bool> fixed_;  ///< one a link: does not move
  std::vector<Solid> workcell_solids_, grown_workcell_solids_;
  std::vector<PlacedSolid> workcell_, grown_workcell_;
  std::vector<Solid> obstacle_solids_;
  std::vector<PlacedSolid> obstacles_;
  Solid target_{geometry::TriangleMesh()};
  double table_z_m_ = 0.0;
  std::vector<std::vector<PlacedSolid>> placed_;  ///< links, then the hand, as being checked
};

}  // namespace rangegrasp::collision
