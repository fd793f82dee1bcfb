#include "geometry/alpha_shape.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace rangegrasp::geometry {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using AlphaKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangle = std::array<std::uint32_t, 3>;

using Vertex3 = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, AlphaKernel>;
/// Each cell stores its squared circumradius.
using Cell3 = CGAL::Triangulation_cell_base_with_info_3<
    double, AlphaKernel, CGAL::Delaunay_triangulation_cell_base_3<AlphaKernel>>;
using Delaunay3 =
    CGAL::Delaunay_triangulation_3<AlphaKernel,
                                   CGAL::Triangulation_data_structure_3<Vertex3, Cell3>>;
using Vertex2 = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, AlphaKernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<
    AlphaKernel,
    CGAL::Triangulation_data_structure_2<Vertex2, CGAL::Triangulation_face_base_2<AlphaKernel>>>;

// Triangulations are built in canonical order: they do not depend on the order of the input.

constexpr double kNoAlpha = std::numeric_limits<double>::infinity();

/// Squared radius of the circle or sphere through the corners; infinite if they are on one line or
/// plane, where the formula divides by zero. The corners are sorted by their coordinates: in
/// another order the radius of a needle rounds differently, and CGAL orders the corners of a facet
/// as in the one of its two cells with the lower memory address.
template <std::size_t n>
double SquaredCircumradius(std::array<AlphaKernel::Point_3, n> corners) {
  std::ranges::sort(corners);
  const double radius =
      std::apply([](const auto&... corner) { return CGAL::squared_radius(corner...); }, corners);
  return std::isfinite(radius) ? radius : kNoAlpha;
}

/// Squared radius of the smallest empty circumsphere of a Delaunay triangle: its own smallest one
/// if neither cell's far vertex is inside it (a Gabriel triangle), else the smaller cell's.
double SquaredEmptyRadius(const Delaunay3& delaunay, const Delaunay3::Facet& facet) {
  const auto [cell, far] = facet;
  const auto other = cell->neighbor(far);
  const auto& a = cell->vertex((far + 1) & 3)->point();
  const auto& b = cell->vertex((far + 2) & 3)->point();
  const auto& c = cell->vertex((far + 3) & 3)->point();
  const auto inside = [&](const auto& side, int vertex) {
    return !delaunay.is_infinite(side->vertex(vertex)) &&
           CGAL::side_of_bounded_sphere(a, b, c, side->vertex(vertex)->point()) ==
               CGAL::ON_BOUNDED_SIDE;
  };
  if (inside(cell, far) || inside(other, other->index(cell))) {
    return std::min(cell->info(), other->info());
  }
  return SquaredCircumradius<3>({a, b, c});
}

auto ToCgal(const Vector2d& p) { return AlphaKernel::Point_2(p.x(), p.y()); }
auto ToCgal(const Vector3d& p) { return AlphaKernel::Point_3(p.x(), p.y(), p.z()); }

/// The triangulation of the points, each position once.
template <class Delaunay, class PointsOf>
Delaunay Triangulate(const PointsOf& points) {
  const Indices order = CanonicalOrder(points);
  const Indices twin = FirstTwin(points, order);
  std::vector<std::pair<decltype(ToCgal(points[0])), std::uint32_t>> input;
  input.reserve(points.size());
  for (const std::uint32_t i : order) {
    if (twin[i] == i) input.emplace_back(ToCgal(points[i]), i);
  }
  return Delaunay(input.begin(), input.end());
}

void AddTriangle(Triangle corners, std::vector<Triangle>& triangles) {
  std::ranges::sort(corners);
  triangles.push_back(corners);
}

void CollectTriangles3(Delaunay3& delaunay, double squared_alpha,
                       std::vector<Triangle>& triangles) {
  for (const auto& cell : delaunay.all_cell_handles()) {
    cell->info() =
        delaunay.is_infinite(cell)
            ? kNoAlpha
            : SquaredCircumradius<4>({cell->vertex(0)->point(), cell->vertex(1)->point(),
                                      cell->vertex(2)->point(), cell->vertex(3)->point()});
  }
  for (const auto& facet : delaunay.finite_facets()) {
    const auto [cell, far] = facet;
    const auto a = cell->vertex((far + 1) & 3);
    const auto b = cell->vertex((far + 2) & 3);
    const auto c = cell->vertex((far + 3) & 3);
    // No circumradius is smaller than half the longest side: this rejects most large triangles.
    const double longest = std::max({CGAL::squared_distance(a->point(), b->point()),
                                     CGAL::squared_distance(b->point(), c->point()),
                                     CGAL::squared_distance(c->point(), a->point())});
    if (longest > 4.0 * squared_alpha) continue;
    if (SquaredEmptyRadius(delaunay, facet) > squared_alpha) continue;
    AddTriangle({a->info(), b->info(), c->info()}, triangles);
  }
}

/// For coplanar points: the triangles of the 2-D triangulation, each with its own circumcircle.
void CollectTriangles2(const Delaunay3& delaunay, double squared_alpha,
                       std::vector<Triangle>& triangles) {
  for (const auto& [cell, far] : delaunay.finite_facets()) {
    const auto& [a, b, c] = std::array{cell->vertex(0), cell->vertex(1), cell->vertex(2)};
    if (SquaredCircumradius<3>({a->point(), b->point(), c->point()}) > squared_alpha) continue;
    AddTriangle({a->info(), b->info(), c->info()}, triangles);
  }
}

double Cross(const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

double LoopLength(std::span<const Vector2d> points, const std::vector<std::uint32_t>& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    length += (points[loop[(i + 1) % loop.size()]] - points[loop[i]]).norm();
  }
  return length;
}

using EdgesFrom = std::map<std::uint32_t, std::vector<std::uint32_t>>;

/// The triangles' directed edges without a reverse, by start point, with ascending end points.
EdgesFrom BoundaryEdges(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& [a, b, c] : triangles) edges.insert(edges.end(), {{a, b}, {b, c}, {c, a}});
  std::ranges::sort(edges);
  EdgesFrom from;
  for (const auto& [a, b] : edges) {
    if (!std::ranges::binary_search(edges, std::pair(b, a))) from[a].push_back(b);
  }
  return from;
}

/// Of the edges that leave `at`, the one that turns furthest to the right when coming from
/// `before`. With the interior on the left, this separates loops that touch at a point.
auto SharpestRight(std::span<const Vector2d> points, std::uint32_t before, std::uint32_t at,
                   const std::vector<std::uint32_t>& next) {
  const Vector2d in = points[at] - points[before];
  const auto turn = [&](std::uint32_t i) {
    const Vector2d out = points[i] - points[at];
    return std::atan2(Cross(in, out), in.dot(out));
  };
  return std::ranges::min_element(next, {}, turn);
}

std::vector<std::vector<std::uint32_t>> ChainLoops(std::span<const Vector2d> points,
                                                   EdgesFrom from) {
  std::vector<std::vector<std::uint32_t>> loops;
  while (!from.empty()) {
    const std::uint32_t start = from.begin()->first;
    std::vector<std::uint32_t> loop{start};
    std::uint32_t before = start;
    std::uint32_t at = start;
    while (true) {
      const auto edges = from.find(at);
      const auto pick = loop.size() == 1 ? edges->second.begin()
                                         : SharpestRight(points, before, at, edges->second);
      before = at;
      at = *pick;
      edges->second.erase(pick);
      if (edges->second.empty()) from.erase(edges);
      if (at == start) break;
      const auto again = std::ranges::find(loop, at);
      if (again == loop.end()) {
        loop.push_back(at);
        continue;
      }
      // The triangles on both sides touch in this point: a loop of its own.
      loops.emplace_back(again, loop.end());
      loop.erase(again + 1, loop.end());
      before = *(again - 1);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

AlphaShape2 ShapeOf(const Delaunay2& delaunay, std::span<const Vector2d> points, double alpha_m) {
  AlphaShape2 shape;
  const double squared_alpha = alpha_m * alpha_m;
  for (const auto& face : delaunay.finite_face_handles()) {
    const auto& a = face->vertex(0);
    const auto& b = face->vertex(1);
    const auto& c = face->vertex(2);
    if (CGAL::squared_radius(a->point(), b->point(), c->point()) > squared_alpha) continue;
    Triangle triangle{a->info(), b->info(), c->info()};
    std::ranges::rotate(triangle, std::ranges::min_element(triangle));
    shape.triangles.push_back(triangle);
    shape.area_m2 += 0.5 * Cross(points[triangle[1]] - points[triangle[0]],
                                 points[triangle[2]] - points[triangle[0]]);
  }
  std::ranges::sort(shape.triangles);
  shape.loops = ChainLoops(points, BoundaryEdges(shape.triangles));
  std::ranges::stable_sort(shape.loops, std::ranges::greater(),
                           [&](const auto& loop) { return LoopLength(points, loop); });
  return shape;
}

}  // namespace

std::vector<Triangle> AlphaTriangles(PointSpan points, double alpha_m) {
  std::vector<Triangle> triangles;
  if (points.size() < 3) return triangles;
  auto delaunay = Triangulate<Delaunay3>(points);
  const double squared_alpha = alpha_m * alpha_m;
  if (delaunay.dimension() == 3) CollectTriangles3(delaunay, squared_alpha, triangles);
  if (delaunay.dimension() == 2) CollectTriangles2(delaunay, squared_alpha, triangles);
  std::ranges::sort(triangles);
  return triangles;
}

AlphaShape2 BuildAlphaShape2(std::span<const Vector2d> points, double alpha_m) {
  return std::move(BuildAlphaShapes2(points, {&alpha_m, 1}).front());
}

std::vector<AlphaShape2> BuildAlphaShapes2(std::span<const Vector2d> points,
                                           std::span<const double> alphas_m) {
  std::vector<AlphaShape2> shapes(alphas_m.size());
  if (points.size() < 3) return shapes;
  const auto delaunay = Triangulate<Delaunay2>(points);
  if (delaunay.dimension() < 2) return shapes;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    shapes[i] = ShapeOf(delaunay, points, alphas_m[i]);
  }
  return shapes;
}

}  // namespace rangegrasp::geometry
