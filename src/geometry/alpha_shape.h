#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The triangles of the 3-D Delaunay triangulation whose smallest empty circumsphere has a radius
/// <= alpha (Edelsbrunner and Muecke 1994; section 2.6.1), and the connected components of the
/// points over them (the triangle connectivity filter).
struct AlphaComplex {
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< positions in the points
  std::vector<std::int32_t> component;  ///< one a point: 0, 1, ... by descending size, ties by
                                        ///< first point; -1 if in no triangle
  std::int32_t components = 0;
};
/// O(n log n) for the surfaces that scans give. Independent of the order of the points but for how
/// components of the same size are numbered.
AlphaComplex BuildAlphaComplex(PointSpan points, double alpha_m);

/// The 2-D alpha shape of points in the plane: triangles of the Delaunay triangulation with
/// circumradius <= alpha, and its boundary as closed loops of point positions (outer loops
/// counter-clockwise, holes clockwise), longest first.
struct AlphaShape2 {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<std::uint32_t>> loops;
  double area_m2 = 0.0;
};
AlphaShape2 BuildAlphaShape2(std::span<const Eigen::Vector2d> points, double alpha_m);
/// One shape for each alpha, from one triangulation, which takes most of the time.
std::vector<AlphaShape2> BuildAlphaShapes2(std::span<const Eigen::Vector2d> points,
                                           std::span<const double> alphas_m);

/// The components of BuildAlphaComplex, several times faster on scans: most points are joined by
/// triangles that their nearest neighbors prove to be in the complex; the triangulation is built
/// only where sets are nearer than 2 alpha to each other (the source says why that is exact).
struct AlphaComponents {
  std::vector<std::int32_t> component;  ///< as in AlphaComplex
  std::int32_t components = 0;
};
/// @param tree  over these points.
AlphaComponents FindAlphaComponents(PointSpan points, const KdTree& tree, double alpha_m);

}  // namespace rangegrasp::geometry
