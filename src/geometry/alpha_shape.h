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
/// sorted. Of several points at one position, only the first has triangles. O(n log n) for scanned
/// surfaces. The result does not depend on the order of the points.
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

}  // namespace rangegrasp::geometry
