#pragma once

#include "base/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::geometry {

/// How far a shape reaches from its own frame's origin along a unit direction of that frame [m]:
/// its support function. Exact; of meshes that of their hull.
double Support(const Shape& shape, const Eigen::Vector3d& direction_S);

/// The same for a shape whose body is at X_AB, from A's origin along a unit direction of A [m].
double Support(const Shape& shape, const base::Pose& X_AB, const Eigen::Vector3d& direction_A);

/// A shape that holds all points within margin_m of the given one, and hardly more: exact for
/// spheres and capsules; boxes, cylinders and ellipsoids grow by it along their axes; the vertices
/// of convex pieces move away from their middle by it. Surfaces (kMesh) stay: they have no inside.
Shape Grown(Shape shape, double margin_m);

/// Whether p_B lies inside a shape of the body frame B. Meshes count as the ellipsoid inscribed in
/// their bounding box.
bool Inside(const Shape& shape, const Eigen::Vector3d& p_B);

}  // namespace rangegrasp::geometry
