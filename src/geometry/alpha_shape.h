#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The triangles of the 3-D Delaunay triangulation whose smallest empty circumsphere has a radius
/// <= alpha (Edelsbrunner and Muecke 1994; section 2.6.1), as ascending indices into the points,
/// sorted. O(n log n) for scanned surfaces. The result does not depend on the order of the points.
std::vector<std::array<std::uint32_t, 3>> AlphaTriangles(PointSpan points, double alpha_m);

/// The 2-D alpha shape of points in the plane: triangles of the Delaunay triangulation with
/// circumradius <= alpha, and its boundary as closed loops of point indices (outer loops
/// counter-clockwise, holes clockwise), longest first.
struct AlphaShape2 {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<std::uint32_t>> loops;
  double area_m2 = 0.0;
};
AlphaShape2 BuildAlphaShape2(std::span<const Eigen::Vector2d> points, double alpha_m);
/// One shape per alpha from a single triangulation, which takes most of the time.
std::vector<AlphaShape2> BuildAlphaShapes2(std::span<const Eigen::Vector2d> points,
                                           std::span<const double> alphas_m);

/// The components of the points that AlphaTriangles connect (the triangle connectivity filter).
/// Points at one position are in one component.
struct AlphaComponents {
  std::vector<std::int32_t> component;  ///< one per point: 0, 1, ... by descending size, ties by
                                        ///< first point; -1 if in no triangle
  std::int32_t components = 0;
};
AlphaComponents FindAlphaComponents(PointSpan points, double alpha_m);

}  // namespace rangegrasp::geometry
