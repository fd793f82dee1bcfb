#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/frames.h"
#include "geometry/mesh.h"
#include "geometry/plane.h"
#include "robot/hand_model.h"

namespace rangegrasp::grasp {

/// The hand in any of its states against surfaces and the table, by trees of oriented boxes
/// (Gottschalk, Lin and Manocha 1996; FCL's BVHModel<OBB>). Trees are built once: one for each
/// surface, one for each shape of the hand, which only moves from state to state.
/// Surfaces are surfaces: what lies wholly inside another is found only where an obstacle lies
/// inside a shape of the hand. A shape of the hand wholly inside an obstacle is not, but the shapes
/// beside it that lead out of the obstacle are.
class HandCollider {
 public:
  /// @param obstacles_C  must keep object_clearance_m to the hand: its shapes are grown by that
  /// @param own_C        the object to be grasped: must not be touched before the hand closes
  /// @param table_C      normal away from the table; the hand stays table_clearance_m above
  HandCollider(const robot::HandModel& hand, std::span<const geometry::TriangleMesh> obstacles_C,
               const geometry::TriangleMesh& own_C, const geometry::Plane& table_C,
               double object_clearance_m, double table_clearance_m);
  ~HandCollider();
  HandCollider(HandCollider&&) noexcept;
  HandCollider& operator=(HandCollider&&) noexcept;

  /// Another surface of the object to be grasped.
  void SetOwn(const geometry::TriangleMesh& own_C);

  bool HitsObstacle(const core::Pose& X_CH, std::size_t state) const;
  bool HitsOwn(const core::Pose& X_CH, std::size_t state) const;
  bool HitsTable(const core::Pose& X_CH, std::size_t state) const;
  /// The lowest point of the hand above the table [m].
  double TableDistance(const core::Pose& X_CH, std::size_t state) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A shape grown by margin_m: exact for spheres and capsules, at least the margin for cylinders and
/// boxes, about the centroid for meshes.
geometry::Shape Grown(geometry::Shape shape, double margin_m);

/// Whether p lies inside a shape; p and the shape in the same frame. Meshes count as their bounding
/// box's inscribed ellipsoid.
bool Inside(const geometry::Shape& shape, const Eigen::Vector3d& p);

}  // namespace rangegrasp::grasp
