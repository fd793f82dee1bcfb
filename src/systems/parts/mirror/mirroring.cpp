#include "parts/mirror/mirroring.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/units.h"
#include "geometry/graph.h"
#include "geometry/kd_tree.h"
#include "geometry/mesh.h"
#include "geometry/plane.h"
#include "parts/cloud/cloud_mesh.h"
#include "parts/mirror/internal/spherical_mirror.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;

// ---- whether a point is inside ----

// The solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983), positive if
// seen from behind.
double SolidAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double det = a.dot(b.cross(c));
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(det, rest);
}

bool IsInsideMesh(const Shape& mesh, const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const Face& f : TurnedOutwards(mesh)) {
    angle += SolidAngle(mesh.points[f[0]] - p, mesh.points[f[1]] - p, mesh.points[f[2]] - p);
  }
  return angle >= 0.5 * 4.0 * base::kPi;
}

// Cells of equal width on the faces of a cube around p; a cell is covered if a point is seen in it.
bool IsInsideCloud(const Points& points, const Eigen::Vector3d& p) {
  constexpr double kPointsACell = 8.0;  // fewer: gaps between points leave cells uncovered
  constexpr double kMaxSide = 8.0;      // 384 cells; more would see through holes of the surface
  const auto side = static_cast<int>(std::clamp(
      std::sqrt(static_cast<double>(points.size()) / (6.0 * kPointsACell)), 1.0, kMaxSide));
  std::vector<bool> covered(6 * side * side, false);
  for (const Eigen::Vector3d& q : points) {
    const Eigen::Vector3d d = q - p;
    if (!(d.squaredNorm() > 0.0)) return true;
    covered[CubeCell(d, side)] = true;
  }
  const auto count = std::count(covered.begin(), covered.end(), true);
  return 2 * static_cast<std::size_t>(count) >= covered.size();
}

// ---- eq. 6.3: which images the outer hull consists of ----

// The farthest image in each of 384 directions: their hull contains most of the others.
Points Farthest(const Points& images, const Eigen::Vector3d& center) {
  // Cells along a side of the cube of directions. With more cells the hull is more expensive, with
  // fewer it contains less. The core does not depend on it.
  constexpr int kSide = 8;
  std::vector<std::optional<std::uint32_t>> best(6 * kSide * kSide);
  std::vector<double> distance(best.size(), -1.0);
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    const Eigen::Vector3d d = images[i] - center;
    const std::size_t cell = CubeCell(d, kSide);
    if (d.squaredNorm() <= distance[cell]) continue;
    distance[cell] = d.squaredNorm();
    best[cell] = i;
  }
  Points farthest;
  for (const auto i : best) {
    if (i) farthest.push_back(images[*i]);
  }
  return farthest;
}

// The points whose images are corners of the outer hull, ascending. These are among the images that
// are not well inside the hull of some of them.
Indices HullPoints(const Points& images, const Eigen::Vector3d& center) {
  const HullSide within(geometry::ConvexHull(Farthest(images, center)), center);
  HullSide::Hint hint;
  Indices candidates;
  for (const std::uint32_t i : SpatialOrder(images)) {
    if (!within.ContainsWell(images[i], hint)) candidates.push_back(i);
  }
  const auto hull = geometry::ConvexHull(geometry::Select(images, candidates));
  std::erase_if(candidates, [&](std::uint32_t i) {
    return !std::ranges::binary_search(hull.vertices, CoordinatesOf(images[i]), {}, CoordinatesOf);
  });
  std::ranges::sort(candidates);
  return candidates;
}

// ---- eq. 6.4 and 6.7: offsets of the hull's points ----

std::vector<double> MeshOffsets(const Shape& mesh, const Indices& points,
                                const Eigen::Vector3d& center) {
  std::vector<bool> wanted(mesh.points.size(), false);
  for (const std::uint32_t i : points) wanted[i] = true;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& face : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!wanted[face[i]]) continue;
      edges.emplace_back(face[i], face[(i + 1) % 3]);
      edges.emplace_back(face[i], face[(i + 2) % 3]);
    }
  }
  const auto joined = geometry::MakeAdjacency(edges, mesh.points.size());
  std::vector<double> offsets;
  for (const std::uint32_t i : points) {
    const Points around = geometry::Select(mesh.points, joined.Of(i));
    offsets.push_back(Offset(mesh.points[i], around, center));
  }
  return offsets;
}

std::vector<double> CloudOffsets(const Shape& cloud, const Indices& points,
                                 const Eigen::Vector3d& center) {
  const Indices order = SpatialOrder(cloud.points);
  const Points ordered = geometry::Select(cloud.points, order);
  const KdTree tree(ordered);
  const double d_max = geometry::NearestNeighborDistances(ordered, tree).max_m;
  std::vector<double> offsets;
  std::vector<KdTree::Neighbor> found;
  Indices neighbors;
  for (const std::uint32_t i : points) {
    // Slightly more than d_max, so that the pair that defines it finds each other.
    constexpr double kCoreSlack = 1.0 + 1e-9;
    tree.Within(cloud.points[i], d_max * kCoreSlack, found);
    neighbors.clear();
    for (const auto& n : found) {
      if (order[n.index] != i) neighbors.push_back(order[n.index]);
    }
    std::sort(neighbors.begin(), neighbors.end());
    offsets.push_back(Offset(cloud.points[i], geometry::Select(cloud.points, neighbors), center));
  }
  return offsets;
}

// ---- the center ----

Eigen::Vector3d CenterOfGravity(const Shape& shape) {
  if (!shape.IsMesh()) return geometry::Centroid(shape.points);
  const Eigen::Vector3d origin = shape.points[0];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const auto& f : shape.faces) {
    const Eigen::Vector3d a = shape.points[f[0]] - origin;
    const Eigen::Vector3d b = shape.points[f[1]] - origin;
    const Eigen::Vector3d c = shape.points[f[2]] - origin;
    const double face_area = 0.5 * (b - a).cross(c - a).norm();
    sum += face_area * (a + b + c) / 3.0;
    area += face_area;
  }
  return origin + sum / area;
}

bool FindCenter(const Shape& shape, bool go_on_outside, Core& core) {
  core.center = SmallestEnclosingSphere(shape.points).center;
  if (IsInside(shape, core.center)) return true;
  const Eigen::Vector3d other = CenterOfGravity(shape);
  core.used_centroid = core.center_inside = IsInside(shape, other);
  if (core.used_centroid) core.center = other;
  return core.center_inside || go_on_outside;
}

// ---- section 6.2.2: what is outside of the core ----

Labels FillMesh(const Shape& mesh, const std::vector<bool>& point_in_core) {
  std::vector<bool> rest;
  for (const Face& face : mesh.faces) {
    rest.push_back(!std::ranges::all_of(face, [&](std::uint32_t v) { return point_in_core[v]; }));
  }
  Labels label = ConnectedPieces(BuildFaceGraph(mesh), rest, AnyNeighbors).label;
  for (std::int32_t& l : label) ++l;  // 0 is the core
  return label;
}

// Pieces with no more points than a neighborhood are crumbs. Each of their points goes to the part
// or core of the nearest point that is not in a crumb.
void JoinSmallPieces(const Points& points, Labels& label) {
  std::map<std::int32_t, std::size_t> count;
  for (const std::int32_t l : label) ++count[l];
  const auto is_crumb = [&](std::int32_t l) { return l > 0 && count[l] <= kCloudNeighbors; };
  LabelByNearest(points, geometry::PositionsWhere(label, std::not_fn(is_crumb)),
                 geometry::PositionsWhere(label, is_crumb), label);
}

// Numbers the parts from 1 by decreasing size, on ties by their first point; the core stays 0.
void NumberBySize(Labels& label) {
  std::vector<double> size(*std::ranges::max_element(label) + 1, 0.0);
  Indices parts;
  for (const std::int32_t l : label) {
    if (l > 0 && size[l] == 0.0) parts.push_back(static_cast<std::uint32_t>(l));
    size[l] += 1.0;
  }
  const Labels number = RankLabels(std::move(parts), size);
  for (std::int32_t& l : label) l = number[l] + 1;
}

// Flood filling of points at d < d_a (eq. 6.8). Returns the pieces, numbered by decreasing size.
Labels FloodFill(const Points& points) {
  // Slightly more than the mean, so that rounding does not separate points at that distance.
  constexpr double kMirrorSlack = 1.0 + 1e-9;
  const KdTree tree(points);
  struct Link {
    std::uint32_t a, b;
    double squared;
  };
  std::vector<Link> links;
  std::vector<double> reach;  // squared distance to the last of a point's neighbors
  std::vector<KdTree::Neighbor> found;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Nearest(points[i], kCloudNeighbors + 1, found);
    for (const auto& n : found) {
      if (n.index != i) links.push_back({i, n.index, n.squared_distance});
    }
    reach.push_back(found.back().squared_distance);
    sum += std::sqrt(reach.back());
  }
  const double d_a = sum / static_cast<double>(points.size()) * kMirrorSlack;
  geometry::UnionFind sets(points.size());
  for (const Link& link : links) {
    if (link.squared <= std::max(d_a * d_a, reach[link.b])) sets.Unite(link.a, link.b);
  }
  Labels piece;
  geometry::LabelBySize(sets, std::vector<bool>(points.size(), true), piece);
  return piece;
}

Labels FillCloud(const Shape& cloud, const std::vector<bool>& in_core) {
  const Indices rest = geometry::PositionsWhere(in_core, [](bool inside) { return !inside; });
  Labels label(in_core.size(), 0);
  if (rest.empty()) return label;
  const Points outside = geometry::Select(cloud.points, rest);
  const Indices order = SpatialOrder(outside);
  const Labels piece = FloodFill(geometry::Select(outside, order));
  for (std::size_t k = 0; k < rest.size(); ++k) label[rest[order[k]]] = piece[k] + 1;
  JoinSmallPieces(cloud.points, label);
  NumberBySize(label);
  return label;
}

Segmentation Mirror(const Shape& shape, bool go_on_outside) {
  const auto core = ExtractCore(shape, go_on_outside);
  if (!core) {
    throw base::InputError(
        "neither the centre of the smallest enclosing sphere nor the centre of gravity is inside "
        "the shape; use --go-on-outside to segment it nevertheless, or --method hierarchy; from a "
        "scan with a table, first cut out an object: `rangegrasp perceive CLOUD -o DIR`");
  }
  Segmentation result;
  result.label = shape.IsMesh() ? FillMesh(shape, core->inside) : FillCloud(shape, core->inside);
  result.has_core = std::ranges::find(result.label, 0) != result.label.end();
  if (!result.has_core) {
    for (std::int32_t& l : result.label) --l;
  }
  result.parts = 1 + *std::ranges::max_element(result.label);
  if (!core->center_inside) {
    result.note = "no centre inside was found; mirrored at that of the smallest enclosing sphere";
  } else if (core->used_centroid) {
    result.note =
        "the centre of the smallest enclosing sphere is outside; mirrored at the centre "
        "of gravity";
  }
  return result;
}

/// Surface points that replace a noisy cloud; nullopt if it is not noisy or they are flat.
std::optional<Shape> Calmed(const Points& points) {
  constexpr double kNoisy = 0.25;  // with more, in spacings, neighborhoods are slabs, not surfaces
  const CloudSampling sampling = MeasureSampling(points, KdTree(points));
  if (!(sampling.noise > kNoisy * sampling.spacing)) return std::nullopt;
  Shape calm{PointsOfSurface(points).points, {}, {}};
  if (geometry::IsFlat(calm.points)) return std::nullopt;
  return calm;
}

}  // namespace

bool IsInside(const Shape& shape, const Eigen::Vector3d& p) {
  return shape.IsMesh() ? IsInsideMesh(shape, p) : IsInsideCloud(shape.points, p);
}

std::optional<Core> ExtractCore(const Shape& shape, bool go_on_outside) {
  Core core;
  if (!FindCenter(shape, go_on_outside, core)) return std::nullopt;
  const Sphere sphere = SphereRound(core.center, shape.points);
  const Points images = MirrorOut(shape.points, sphere);
  const Indices hull_points = HullPoints(images, core.center);
  const auto offsets = shape.IsMesh() ? MeshOffsets(shape, hull_points, core.center)
                                      : CloudOffsets(shape, hull_points, core.center);
  Points back;
  for (std::size_t k = 0; k < hull_points.size(); ++k) {
    back.push_back(MirrorIn(images[hull_points[k]], sphere, offsets[k]));
  }
  core.inside.assign(shape.points.size(), false);
  // Eq. 6.6. The order of the points affects the time, but not the hull.
  const HullSide inner(geometry::ConvexHull(geometry::Select(back, SpatialOrder(back))),
                       core.center);
  HullSide::Hint hint;
  for (const std::uint32_t i : SpatialOrder(shape.points)) {
    core.inside[i] = inner.Contains(shape.points[i], hint);
  }
  // Their own images span the hull, regardless of rounding (if it is flat, only they are inside).
  for (const std::uint32_t i : hull_points) core.inside[i] = true;
  return core;
}

Segmentation SegmentByMirroring(const Shape& shape, bool go_on_outside) {
  const auto calm = shape.IsMesh() ? std::nullopt : Calmed(shape.points);
  if (!calm) return Mirror(shape, go_on_outside);
  Segmentation found = Mirror(*calm, go_on_outside);
  found.label = LabelsOfNearest(shape.points, calm->points, found.label);
  return found;
}

}  // namespace rangegrasp::parts
