#pragma once

#include <string>

#include "base/frames.h"
#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// A rigid collision shape and its pose in the frame B of the body that carries it.
/// Sizes follow MuJoCo: sphere (radius), capsule and cylinder (radius, half length along z), box
/// and ellipsoid (half sizes).
struct Shape {
  enum class Kind { kSphere, kCapsule, kCylinder, kBox, kEllipsoid, kConvex, kMesh };
  Kind kind = Kind::kSphere;
  base::Pose X_BS = base::Pose::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< [m]
  TriangleMesh mesh;  ///< kConvex (used as its hull), kMesh (a surface); in the shape's frame
  std::string name;
};

/// The surface of a shape as triangles in frame B; round shapes get `segments` sides.
TriangleMesh Tessellate(const Shape& shape, int segments = 24);

/// The support function of a shape: how far it reaches from its frame's origin along a unit
/// direction of that frame [m]. Exact; for meshes it is that of their hull.
double Support(const Shape& shape, const Eigen::Vector3d& direction_S);

/// The same for a shape whose body is at X_AB, from A's origin along a unit direction of A [m].
double Support(const Shape& shape, const base::Pose& X_AB, const Eigen::Vector3d& direction_A);

/// A shape grown by margin_m: exact for spheres and capsules; boxes, cylinders and ellipsoids grow
/// along their axes; vertices of convex pieces move away from their center. kMesh is unchanged.
Shape Grown(Shape shape, double margin_m);

/// Whether p_B is inside a shape; a mesh counts as the ellipsoid inscribed in its bounding box.
bool Inside(const Shape& shape, const Eigen::Vector3d& p_B);

}  // namespace rangegrasp::geometry
