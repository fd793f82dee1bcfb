#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// The convex hull (eq. 5.1) as a closed triangle mesh, faces outward; empty if the points are
/// (nearly) in one plane.
TriangleMesh ConvexHull(PointSpan points);

/// The convex hull of points in the plane, counter-clockwise.
std::vector<Eigen::Vector2d> ConvexHull2(std::span<const Eigen::Vector2d> points);

}  // namespace rangegrasp::geometry
