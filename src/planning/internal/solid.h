#pragma once

#include <fcl/geometry/collision_geometry.h>

#include <memory>
#include <vector>

#include "core/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::planning::internal {

/// An axis-aligned box.
struct Bounds {
  Eigen::Vector3d low, high;
  bool Overlaps(const Bounds& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

/// A collision shape of FCL with what the broad phase needs to know about it.
class Solid {
 public:
  /// The shape grown by margin_m: exact for spheres, enclosing for capsules, boxes, cylinders and
  /// ellipsoids; of convex pieces each vertex moves away from their middle. Surfaces stay as they
  /// are.
  Solid(const geometry::Shape& shape, double margin_m);
  /// A surface in its own frame.
  explicit Solid(const geometry::TriangleMesh& mesh);

  const core::Pose& X_BS() const { return X_BS_; }
  Bounds BoundsAt(const core::Pose& X_WS) const;
  /// The z of its lowest point.
  double LowestAt(const core::Pose& X_WS) const;
  bool Hits(const core::Pose& X_WS, const Solid& other, const core::Pose& X_WOther) const;

 private:
  void SetMesh(const geometry::TriangleMesh& mesh, double margin_m);
  /// Half the extent of a round or boxy shape along the axis (unit, in its frame).
  double HalfExtent(const Eigen::Vector3d& axis_S) const;

  geometry::Shape::Kind kind_;
  core::Pose X_BS_ = core::Pose::Identity();
  Eigen::Vector3d size_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> vertices_;  // of a mesh
  Bounds box_;                             // of a mesh, in its frame
  std::shared_ptr<fcl::CollisionGeometryd> geometry_;
};

}  // namespace rangegrasp::planning::internal
