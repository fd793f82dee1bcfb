#include "geometry/alpha_shape.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "geometry/adjacency.h"
#include "geometry/union_find.h"

namespace rangegrasp::geometry {
namespace {

using AlphaKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangle = std::array<std::uint32_t, 3>;

using Vertex3 = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, AlphaKernel>;
/// Each cell carries its squared circumradius.
using Cell3 = CGAL::Triangulation_cell_base_with_info_3<
    double, AlphaKernel, CGAL::Delaunay_triangulation_cell_base_3<AlphaKernel>>;
using Delaunay3 =
    CGAL::Delaunay_triangulation_3<AlphaKernel,
                                   CGAL::Triangulation_data_structure_3<Vertex3, Cell3>>;
using Vertex2 = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, AlphaKernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<
    AlphaKernel,
    CGAL::Triangulation_data_structure_2<Vertex2, CGAL::Triangulation_face_base_2<AlphaKernel>>>;

constexpr double kNoAlpha = std::numeric_limits<double>::infinity();

/// Positions of the points in lexicographic order of their coordinates, ties by position. The
/// triangulation is built in this order, so that it does not depend on the order of the input.
template <class PointsOf>
std::vector<std::uint32_t> CanonicalOrder(const PointsOf& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&points](std::uint32_t a, std::uint32_t b) {
    const auto& p = points[a];
    const auto& q = points[b];
    for (Eigen::Index i = 0; i < p.size(); ++i) {
      if (p[i] != q[i]) return p[i] < q[i];
    }
    return a < b;
  });
  return order;
}

/// For each point the first point with the same coordinates.
template <class PointsOf>
std::vector<std::uint32_t> FirstTwin(const PointsOf& points,
                                     const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> twin(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && points[order[i]] == points[order[i - 1]];
    twin[order[i]] = same ? twin[order[i - 1]] : order[i];
  }
  return twin;
}

/// Of the circle or sphere through the corners; infinite if they are in one line or plane, where
/// its formula divides by zero. The corners are taken in the order of their coordinates: in
/// another one the radius of a needle rounds to something else, and CGAL names a facet from that
/// one of its two cells which lies lower in memory.
template <std::size_t n>
double SquaredCircumradius(std::array<AlphaKernel::Point_3, n> corners) {
  std::sort(corners.begin(), corners.end());
  const double radius =
      std::apply([](const auto&... corner) { return CGAL::squared_radius(corner...); }, corners);
  return std::isfinite(radius) ? radius : kNoAlpha;
}

/// The smallest empty circumsphere of a Delaunay triangle: its own smallest one if neither
/// neighboring cell's far vertex is inside it (a Gabriel triangle), else the smaller of the
/// cells'.
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

Delaunay3 Triangulate(PointSpan points, const std::vector<std::uint32_t>& order,
                      const std::vector<std::uint32_t>& twin) {
  std::vector<std::pair<AlphaKernel::Point_3, std::uint32_t>> input;
  input.reserve(points.size());
  for (const std::uint32_t i : order) {
    if (twin[i] != i) continue;
    input.emplace_back(AlphaKernel::Point_3(points[i].x(), points[i].y(), points[i].z()), i);
  }
  return Delaunay3(input.begin(), input.end());
}

Triangle SortedTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  Triangle triangle{a, b, c};
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

void CollectTriangles3(Delaunay3& delaunay, double squared_alpha, AlphaComplex& complex) {
  for (const auto& cell : delaunay.all_cell_handles()) {
    cell->info() =
        delaunay.is_infinite(cell)
            ? kNoAlpha
            : SquaredCircumradius<4>({cell->vertex(0)->point(), cell->vertex(1)->point(),
                                      cell->vertex(2)->point(), cell->vertex(3)->point()});
  }
  for (auto facet = delaunay.finite_facets_begin(); facet != delaunay.finite_facets_end();
       ++facet) {
    const auto [cell, far] = *facet;
    const auto a = cell->vertex((far + 1) & 3);
    const auto b = cell->vertex((far + 2) & 3);
    const auto c = cell->vertex((far + 3) & 3);
    // No circumsphere is smaller than half the longest side: most far triangles end here.
    const double longest = std::max({CGAL::squared_distance(a->point(), b->point()),
                                     CGAL::squared_distance(b->point(), c->point()),
                                     CGAL::squared_distance(c->point(), a->point())});
    if (longest > 4.0 * squared_alpha) continue;
    if (SquaredEmptyRadius(delaunay, *facet) > squared_alpha) continue;
    complex.triangles.push_back(SortedTriangle(a->info(), b->info(), c->info()));
  }
}

/// All points in one plane: the triangles of the 2-D triangulation, each with its own circle.
void CollectTriangles2(const Delaunay3& delaunay, double squared_alpha, AlphaComplex& complex) {
  for (auto facet = delaunay.finite_facets_begin(); facet != delaunay.finite_facets_end();
       ++facet) {
    const auto& cell = facet->first;
    if (SquaredCircumradius<3>({cell->vertex(0)->point(), cell->vertex(1)->point(),
                                cell->vertex(2)->point()}) > squared_alpha) {
      continue;
    }
    complex.triangles.push_back(
        SortedTriangle(cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info()));
  }
}

double Cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
  return u.x() * v.y() - u.y() * v.x();
}

double LoopLength(std::span<const Eigen::Vector2d> points, const std::vector<std::uint32_t>& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    length += (points[loop[(i + 1) % loop.size()]] - points[loop[i]]).norm();
  }
  return length;
}

using EdgesFrom = std::map<std::uint32_t, std::vector<std::uint32_t>>;

/// The directed edges of the triangles whose reverse is in none, by their start; ends ascending.
/// O(n): a point has few edges, so that looking through them beats sorting all.
EdgesFrom BoundaryEdges(const std::vector<Triangle>& triangles) {
  std::uint32_t points = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    points = std::max(points, 1 + *std::ranges::max_element(t));
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  const Adjacency ends = MakeAdjacency(edges, points);
  EdgesFrom from;
  for (std::uint32_t a = 0; a < points; ++a) {
    for (const auto b : ends.Of(a)) {
      if (std::ranges::find(ends.Of(b), a) == ends.Of(b).end()) from[a].push_back(b);
    }
    if (const auto of_a = from.find(a); of_a != from.end()) std::ranges::sort(of_a->second);
  }
  return from;
}

/// Of the edges that leave `at`, the one that turns furthest to the right on the way from
/// `before`: with the interior on the left that keeps loops which touch in a point apart.
std::size_t SharpestRight(std::span<const Eigen::Vector2d> points, std::uint32_t before,
                          std::uint32_t at, const std::vector<std::uint32_t>& next) {
  const Eigen::Vector2d in = points[at] - points[before];
  std::size_t best = 0;
  double best_turn = kNoAlpha;
  for (std::size_t i = 0; i < next.size(); ++i) {
    const Eigen::Vector2d out = points[next[i]] - points[at];
    const double turn = std::atan2(Cross(in, out), in.dot(out));
    if (turn < best_turn) {
      best_turn = turn;
      best = i;
    }
  }
  return best;
}

std::vector<std::vector<std::uint32_t>> ChainLoops(std::span<const Eigen::Vector2d> points,
                                                   EdgesFrom from) {
  std::vector<std::vector<std::uint32_t>> loops;
  while (!from.empty()) {
    const std::uint32_t start = from.begin()->first;
    std::vector<std::uint32_t> loop{start};
    std::uint32_t before = start;
    std::uint32_t at = start;
    do {
      const auto edges = from.find(at);
      const std::size_t pick =
          loop.size() == 1 ? 0 : SharpestRight(points, before, at, edges->second);
      before = at;
      at = edges->second[pick];
      edges->second.erase(edges->second.begin() + static_cast<std::ptrdiff_t>(pick));
      if (edges->second.empty()) from.erase(edges);
      loop.push_back(at);
    } while (at != start);
    loop.pop_back();
    loops.push_back(std::move(loop));
  }
  return loops;
}

Delaunay2 Triangulate(std::span<const Eigen::Vector2d> points) {
  const auto order = CanonicalOrder(points);
  const auto twin = FirstTwin(points, order);
  std::vector<std::pair<AlphaKernel::Point_2, std::uint32_t>> input;
  input.reserve(points.size());
  for (const std::uint32_t i : order) {
    if (twin[i] == i) input.emplace_back(AlphaKernel::Point_2(points[i].x(), points[i].y()), i);
  }
  return Delaunay2(input.begin(), input.end());
}

AlphaShape2 ShapeOf(const Delaunay2& delaunay, std::span<const Eigen::Vector2d> points,
                    double alpha_m) {
  AlphaShape2 shape;
  const double squared_alpha = alpha_m * alpha_m;
  for (const auto& face : delaunay.finite_face_handles()) {
    const auto& a = face->vertex(0);
    const auto& b = face->vertex(1);
    const auto& c = face->vertex(2);
    if (CGAL::squared_radius(a->point(), b->point(), c->point()) > squared_alpha) continue;
    Triangle triangle{a->info(), b->info(), c->info()};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    shape.triangles.push_back(triangle);
    shape.area_m2 += 0.5 * Cross(points[triangle[1]] - points[triangle[0]],
                                 points[triangle[2]] - points[triangle[0]]);
  }
  std::sort(shape.triangles.begin(), shape.triangles.end());
  shape.loops = ChainLoops(points, BoundaryEdges(shape.triangles));
  std::stable_sort(shape.loops.begin(), shape.loops.end(), [points](const auto& a, const auto& b) {
    return LoopLength(points, a) > LoopLength(points, b);
  });
  return shape;
}

}  // namespace

AlphaComplex BuildAlphaComplex(PointSpan points, double alpha_m) {
  AlphaComplex complex;
  complex.component.assign(points.size(), -1);
  if (points.size() < 3) return complex;
  const auto order = CanonicalOrder(points);
  const auto twin = FirstTwin(points, order);
  Delaunay3 delaunay = Triangulate(points, order, twin);
  const double squared_alpha = alpha_m * alpha_m;
  if (delaunay.dimension() == 3) CollectTriangles3(delaunay, squared_alpha, complex);
  if (delaunay.dimension() == 2) CollectTriangles2(delaunay, squared_alpha, complex);
  std::sort(complex.triangles.begin(), complex.triangles.end());

  UnionFind sets(points.size());
  std::vector<bool> used(points.size(), false);
  for (const auto& [a, b, c] : complex.triangles) {
    sets.Unite(a, b);
    sets.Unite(a, c);
    used[a] = used[b] = used[c] = true;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[twin[i]]) continue;
    used[i] = true;
    sets.Unite(static_cast<std::uint32_t>(i), twin[i]);
  }
  complex.components = LabelBySize(sets, used, complex.component);
  return complex;
}

AlphaShape2 BuildAlphaShape2(std::span<const Eigen::Vector2d> points, double alpha_m) {
  return std::move(BuildAlphaShapes2(points, {&alpha_m, 1}).front());
}

std::vector<AlphaShape2> BuildAlphaShapes2(std::span<const Eigen::Vector2d> points,
                                           std::span<const double> alphas_m) {
  std::vector<AlphaShape2> shapes(alphas_m.size());
  if (points.size() < 3) return shapes;
  const Delaunay2 delaunay = Triangulate(points);
  if (delaunay.dimension() < 2) return shapes;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    shapes[i] = ShapeOf(delaunay, points, alphas_m[i]);
  }
  return shapes;
}

}  // namespace rangegrasp::geometry
