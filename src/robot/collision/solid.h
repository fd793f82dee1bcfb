#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "base/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::collision {

/// How a shape becomes a solid.
struct SolidOptions {
  double margin_m = 0.0;  ///< the shape is grown by it (geometry::Grown)
  /// 0: spheres, capsules, boxes ... are exact, and what lies wholly inside of them is found.
  /// From 3: their surface as facets with so many sides, in a tree of oriented boxes, moved out
  /// until they lie as much outside of a finger's surface as inside. What lies wholly inside is not
  /// found.
  int sides = 0;
};

/// A body for collision checks, with what the broad phase needs to know of it. Meshes and convex
/// pieces are surfaces in a tree of oriented boxes (Gottschalk, Lin and Manocha 1996; FCL's
/// BVHModel): they are hit where surfaces cross. Copies share the tree. Checks do not change it.
class Solid {
 public:
  explicit Solid(geometry::Shape shape, const SolidOptions& options = {});
  /// A surface in its own frame S; one without triangles is hit by nothing.
  explicit Solid(geometry::TriangleMesh mesh);

  bool IsEmpty() const { return geometry_ == nullptr; }
  /// In the frame B of the body that carries it.
  const base::Pose& X_BS() const { return shape_.X_BS; }
  /// Of a surface or of facets, in S.
  const geometry::Points& Vertices() const { return shape_.mesh.vertices; }
  /// The axis-aligned box about it; of meshes, the one about their own turned box.
  Eigen::AlignedBox3d BoxAt(const base::Pose& X_WS) const;
  /// The z of its lowest point; exact.
  double LowestAt(const base::Pose& X_WS) const;
  /// Whether the two touch: the narrow phase, without a look at the boxes.
  bool Touches(const base::Pose& X_WS, const Solid& other, const base::Pose& X_WOther) const;

 private:
  struct Geometry;
  static std::shared_ptr<const Geometry> MakeGeometry(const geometry::Shape& shape);

  geometry::Shape shape_;    // grown; a mesh where it is facets
  Eigen::AlignedBox3d box_;  // of a mesh, in S
  std::shared_ptr<const Geometry> geometry_;
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

}  // namespace rangegrasp::collision
