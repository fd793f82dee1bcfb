#pragma once

#include <Eigen/Core>
#include <span>

#include "parts/mirror/enclosing_sphere.h"

namespace rangegrasp::parts {

/// Eq. 6.2: outside of the sphere, as far as p was inside of it. A point in the center goes along
/// +x.
Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere);
/// The same of all points.
geometry::Points MirrorOut(geometry::PointSpan points, const Sphere& sphere);
/// Eq. 6.5 with the sign that brings a mirrored point back: to its own radius plus 2 * offset.
Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset);
/// Eq. 6.4 (cloud: neighbors nearer than d_max, the largest of all nearest-neighbor distances)
/// and 6.7 (mesh: vertices joined by an edge): the mean of | |p_n - C| - |p - C| |; 0 without
/// neighbors.
double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center);

}  // namespace rangegrasp::parts
