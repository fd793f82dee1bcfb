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
#include <unordered_map>
#include <utility>

#include "geometry/graph.h"

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
/// if neither neighboring cell's far vertex is inside it (a Gabriel triangle), else the smaller one
/// of the two cells.
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

/// The directed edges of the triangles whose reverse is in no triangle, by start point, with
/// ascending end points. O(n): a point has few edges, so searching them is faster than sorting all.
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

namespace {

// Two facts make the shortcut exact (up to rounding).
//
// 1. Let the ball with diameter pq contain no point inside, and let r give the smallest
//    circumradius R of the triangles pqr. Then the smallest ball through p, q, r contains none:
//    move a ball through p and q from the first to the last. A point inside the last would have
//    been reached on the way at a radius below R, and its triangle would have a smaller
//    circumradius. So pqr is in the complex if R <= alpha. Only points within 2 R of p matter.
//
// 2. A triangle of the complex has sides <= 2 alpha, and its empty ball is within 2 alpha of each
//    of its corners. If it joins two sets, each corner is within 2 alpha of a point of another set.
//    A triangulation of the points within 2 alpha of those corners finds these triangles.

/// 21 bits per coordinate of a cube: cubes 2^21 apart share a number, which only costs time.
constexpr std::uint64_t kCubeMask = 0x1fffffu;
/// Number of neighbors for fact 1, without influence on the result. Fewer leave more to the
/// triangulation, more cost time for every point.
constexpr std::size_t kNeighbors = 12;
/// Above this share of undecided points, triangulating all is cheaper; the result is the same.
constexpr double kMaxUndecided = 0.3;
/// Widens 2 alpha by far more than rounding, since the tree excludes points at exactly the radius.
constexpr double kBeyond = 1.0 + 1e-9;
/// Shrinks a ball, so that rounding does not put a point of its surface inside.
constexpr double kInside = 1.0 - 1e-12;

class Finder {
 public:
  Finder(PointSpan points, const KdTree& tree, double alpha)
      : points_(points),
        tree_(tree),
        alpha_(alpha),
        sets_(points.size()),
        used_(points.size(), false),
        twin_(points.size()) {}

  AlphaComponents Find() {
    for (std::uint32_t i = 0; i < points_.size(); ++i) JoinNeighbors(i);
    JoinUndecided(Undecided());
    // A point is used if any point at the same position is used.
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (used_[i]) used_[twin_[i]] = true;
    }
    for (std::uint32_t i = 0; i < points_.size(); ++i) used_[i] = used_[twin_[i]];
    AlphaComponents result;
    result.components = LabelBySize(sets_, used_, result.component);
    return result;
  }

 private:
  void Use(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    used_[a] = used_[b] = used_[c] = true;
    sets_.Unite(a, b);
    sets_.Unite(a, c);
  }

  /// Applies fact 1 to p and its neighbors that are not yet joined with it.
  void JoinNeighbors(std::uint32_t p) {
    tree_.Nearest(points_[p], kNeighbors, list_);
    twin_[p] = list_.front().index;  // the smallest index at distance 0
    sets_.Unite(p, twin_[p]);
    const double reach = list_.size() < kNeighbors ? kNoAlpha : list_.back().squared_distance;
    for (const KdTree::Neighbor& q : list_) {
      if (q.squared_distance == 0.0) continue;
      if (q.squared_distance > 4.0 * alpha_ * alpha_) break;
      const bool joined = used_[p] && used_[q.index] && sets_.Find(p) == sets_.Find(q.index);
      if (!joined && IsGabriel(p, q)) JoinBest(p, q, reach);
    }
  }

  /// Whether no point is inside the ball with diameter pq; it would be closer to p than q is.
  bool IsGabriel(std::uint32_t p, const KdTree::Neighbor& q) const {
    const Vector3d middle = 0.5 * (points_[p] + points_[q.index]);
    const double inside = 0.25 * q.squared_distance * kInside;
    for (const KdTree::Neighbor& s : list_) {
      if (s.squared_distance >= q.squared_distance) return true;
      if (s.squared_distance > 0.0 && (points_[s.index] - middle).squaredNorm() < inside) {
        return false;
      }
    }
    return true;
  }

  void JoinBest(std::uint32_t p, const KdTree::Neighbor& q, double squared_reach) {
    const Vector3d pq = points_[q.index] - points_[p];
    double best = kNoAlpha;  // squared radius
    std::uint32_t best_r = 0;
    for (const KdTree::Neighbor& r : list_) {
      const Vector3d pr = points_[r.index] - points_[p];
      const double area = pq.cross(pr).squaredNorm();
      const double sides = q.squared_distance * r.squared_distance *
                           (points_[r.index] - points_[q.index]).squaredNorm();
      if (!(area > 0.0) || !(sides < 4.0 * area * best)) continue;
      best = sides / (4.0 * area);
      best_r = r.index;
    }
    if (best <= alpha_ * alpha_ && 4.0 * best <= squared_reach) Use(p, q.index, best_r);
  }

  using CubeSets = std::unordered_map<std::uint64_t, std::int32_t>;

  /// A 3 x 21 bit number of the cube of side 2 alpha that contains p, shifted by (x, y, z) cubes.
  std::uint64_t Cube(const Vector3d& p, int x, int y, int z) const {
    const auto part = [this](double value, int shift) {
      return static_cast<std::uint64_t>(
                 static_cast<std::int64_t>(std::floor(value / (2.0 * alpha_))) + shift) &
             kCubeMask;
    };
    return part(p.x(), x) << 42 | part(p.y(), y) << 21 | part(p.z(), z);
  }

  /// The points within 2 alpha of a point of another set, ascending.
  Indices Undecided() {
    std::vector<std::int32_t> set;  // set of each point; 0 is the largest set
    LabelBySize(sets_, std::vector<bool>(points_.size(), true), set);
    CubeSets largest;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      auto& entry = largest.try_emplace(Cube(points_[i], 0, 0, 0), set[i]).first->second;
      entry = std::min(entry, set[i]);
    }
    CubeSets around;  // the same, including the cubes around it
    std::vector<bool> undecided(points_.size(), false);
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      const auto [entry, is_new] = around.try_emplace(Cube(points_[i], 0, 0, 0), set[i]);
      if (is_new) entry->second = LargestAround(points_[i], set[i], largest);
      // Of two sets, the smaller one searches for the other.
      if (entry->second < set[i]) MarkOthers(i, undecided);
    }
    return PositionsOf(undecided);
  }

  /// The largest set in the cube of p and those around it; p is in the set `own`.
  std::int32_t LargestAround(const Vector3d& p, std::int32_t own, const CubeSets& largest) const {
    std::int32_t best = own;
    for (int k = 0; k < 27; ++k) {
      const auto entry = largest.find(Cube(p, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      if (entry != largest.end()) best = std::min(best, entry->second);
    }
    return best;
  }

  void MarkOthers(std::uint32_t i, std::vector<bool>& undecided) {
    tree_.Within(points_[i], 2.0 * alpha_ * kBeyond, list_);
    const std::uint32_t set = sets_.Find(i);
    for (const KdTree::Neighbor& n : list_) {
      if (sets_.Find(n.index) == set) continue;
      undecided[i] = true;
      undecided[n.index] = true;
    }
  }

  /// Applies fact 2.
  void JoinUndecided(const Indices& undecided) {
    std::vector<bool> may_join(points_.size(), false);
    const bool all =
        static_cast<double>(undecided.size()) > kMaxUndecided * static_cast<double>(points_.size());
    std::vector<bool> needed(points_.size(), all);
    for (const std::uint32_t i : undecided) {
      may_join[i] = true;
      if (all) continue;
      tree_.Within(points_[i], 2.0 * alpha_ * kBeyond, list_);
      for (const KdTree::Neighbor& n : list_) needed[n.index] = true;
    }
    const Indices subset = PositionsOf(needed);
    for (const auto& [a, b, c] : AlphaTriangles(Select(points_, subset), alpha_)) {
      if (may_join[subset[a]] && may_join[subset[b]] && may_join[subset[c]]) {
        Use(subset[a], subset[b], subset[c]);
      }
    }
  }

  PointSpan points_;
  const KdTree& tree_;
  double alpha_;
  UnionFind sets_;
  std::vector<bool> used_;
  Indices twin_;  ///< the first point at the same position
  std::vector<KdTree::Neighbor> list_;
};

}  // namespace

AlphaComponents FindAlphaComponents(PointSpan points, const KdTree& tree, double alpha_m) {
  if (points.empty() || !(alpha_m > 0.0)) {
    return {std::vector<std::int32_t>(points.size(), -1), 0};
  }
  return Finder(points, tree, alpha_m).Find();
}

}  // namespace rangegrasp::geometry
