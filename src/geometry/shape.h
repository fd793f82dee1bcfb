#pragma once

#include <string>
#include <vector>

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
  TriangleMesh mesh;  ///< kConvex (its hull counts) and kMesh (a surface); in the shape's frame
  std::string name;
};

/// The surface of a shape as triangles in frame B; round shapes get `segments` sides.
TriangleMesh Tessellate(const Shape& shape, int segments = 24);

}  // namespace rangegrasp::geometry
