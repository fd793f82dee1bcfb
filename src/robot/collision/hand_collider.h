#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/plane.h"
#include "robot/collision/hand_solids.h"

namespace rangegrasp::collision {

struct HandColliderOptions {
  double object_clearance_m = 0.002;  ///< between the hand and other objects
  double table_clearance_m = 0.004;   ///< of the hand's lowest point above the table
  /// Of the hand's round shapes, see SolidOptions. 0: exact.
  int sides = 12;
};

/// The hand in any of its states against surfaces and the table, for grasps that are looked at by
/// the hundred: trees are built once, the hand's shapes only move.
/// Surfaces are surfaces: what lies wholly inside another is found only where an obstacle lies
/// inside a shape of the hand. A shape of the hand wholly inside an obstacle is not, but the shapes
/// beside it that lead out of the obstacle are. C is any one frame.
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

}  // namespace rangegrasp::collision
