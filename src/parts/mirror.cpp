#include "parts/mirror.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/error.h"
#include "geometry/hull.h"
#include "geometry/kd_tree.h"
#include "geometry/union_find.h"
#include "parts/internal/hull_side.h"
#include "parts/internal/space.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;
using geometry::Points;

// Points round a point that are its neighbours in a cloud: as many as a pixel has.
constexpr std::size_t kNeighbors = 8;

// ---- eq. 6.3: which images the outer hull consists of ----

// The farthest image in each of 384 directions: their hull holds most of the others.
Points Farthest(const Points& images, const Eigen::Vector3d& center) {
  constexpr int kSide = 8;
  constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> best(static_cast<std::size_t>(6 * kSide * kSide), kNone);
  std::vector<double> distance(best.size(), -1.0);
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    const Eigen::Vector3d d = images[i] - center;
    const std::size_t cell = CubeCell(d, kSide);
    if (d.squaredNorm() <= distance[cell]) continue;
    distance[cell] = d.squaredNorm();
    best[cell] = i;
  }
  Points farthest;
  for (const std::uint32_t i : best) {
    if (i != kNone) farthest.push_back(images[i]);
  }
  return farthest;
}

// The order of the points costs or saves time, but does not change the hull.
geometry::TriangleMesh HullOf(const Points& points) {
  return geometry::ConvexHull(geometry::Select(points, SpatialOrder(points)));
}

// The hull's corners are among the images that are not well within the hull of some of them.
std::vector<std::uint32_t> HullPoints(const Points& images, const Eigen::Vector3d& center) {
  const HullSide within(geometry::ConvexHull(Farthest(images, center)), center);
  HullSide::Hint hint;
  std::vector<std::uint32_t> candidates;
  for (const std::uint32_t i : SpatialOrder(images)) {
    if (!within.ContainsWell(images[i], hint)) candidates.push_back(i);
  }
  const auto hull = geometry::ConvexHull(geometry::Select(images, candidates));
  const auto key = [](const Eigen::Vector3d& p) { return std::tie(p.x(), p.y(), p.z()); };
  const auto before = [&key](const auto& p, const auto& q) { return key(p) < key(q); };
  std::vector<std::uint32_t> found;
  for (const std::uint32_t i : candidates) {
    if (std::binary_search(hull.vertices.begin(), hull.vertices.end(), images[i], before)) {
      found.push_back(i);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// ---- eq. 6.4 and 6.7: offsets of the hull's points ----

std::vector<double> MeshOffsets(const Shape& mesh, const std::vector<std::uint32_t>& points,
                                const Eigen::Vector3d& center) {
  std::vector<std::vector<std::uint32_t>> joined(mesh.points.size());
  std::vector<bool> wanted(mesh.points.size(), false);
  for (const std::uint32_t i : points) wanted[i] = true;
  for (const auto& face : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!wanted[face[i]]) continue;
      joined[face[i]].push_back(face[(i + 1) % 3]);
      joined[face[i]].push_back(face[(i + 2) % 3]);
    }
  }
  std::vector<double> offsets;
  Points around;
  for (const std::uint32_t i : points) {
    auto& neighbors = joined[i];
    std::sort(neighbors.begin(), neighbors.end());
    neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
    around = geometry::Select(mesh.points, neighbors);
    offsets.push_back(Offset(mesh.points[i], around, center));
  }
  return offsets;
}

std::vector<double> CloudOffsets(const Shape& cloud, const std::vector<std::uint32_t>& points,
                                 const Eigen::Vector3d& center) {
  const auto order = SpatialOrder(cloud.points);
  const Points ordered = geometry::Select(cloud.points, order);
  const KdTree tree(ordered);
  const double d_max = geometry::NearestNeighborDistances(ordered, tree).max_m;
  std::vector<double> offsets;
  std::vector<KdTree::Neighbor> found;
  std::vector<std::uint32_t> neighbors;
  for (const std::uint32_t i : points) {
    // A little more than d_max, so that the pair that it comes from finds each other.
    tree.Within(cloud.points[i], d_max * (1.0 + 1e-9), found);
    neighbors.clear();
    for (const auto& n : found) {
      if (order[n.index] != i) neighbors.push_back(order[n.index]);
    }
    std::sort(neighbors.begin(), neighbors.end());
    offsets.push_back(Offset(cloud.points[i], geometry::Select(cloud.points, neighbors), center));
  }
  return offsets;
}

// ---- the centre ----

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

bool FindCenter(const Shape& shape, const MirrorOptions& options, Core& core) {
  const Eigen::Vector3d first = SmallestEnclosingSphere(shape.points).center;
  core.center = first;
  if (IsInside(shape, first)) return true;
  core.center = CenterOfGravity(shape);
  core.used_centroid = true;
  if (IsInside(shape, core.center)) return true;
  core.center = first;
  core.used_centroid = false;
  core.center_inside = false;
  return options.go_on_outside;
}

// ---- labels ----

std::vector<bool> CoreElements(const Shape& shape, const Core& core) {
  if (!shape.IsMesh()) return core.inside;
  std::vector<bool> in_core(shape.faces.size());
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    in_core[f] =
        std::ranges::all_of(shape.faces[f], [&](std::uint32_t v) { return core.inside[v]; });
  }
  return in_core;
}

std::vector<std::size_t> CountLabels(const std::vector<std::int32_t>& label) {
  std::vector<std::size_t> count(static_cast<std::size_t>(1 + *std::ranges::max_element(label)), 0);
  for (const std::int32_t l : label) ++count[static_cast<std::size_t>(l)];
  return count;
}

// Pieces of no more points than a neighbourhood has are crumbs: each point of them goes to the part
// or core of the nearest point that is in none.
void JoinCrumbs(const Points& points, std::vector<std::int32_t>& label) {
  const auto count = CountLabels(label);
  const auto is_crumb = [&](std::int32_t l) {
    return l > 0 && count[static_cast<std::size_t>(l)] <= kNeighbors;
  };
  Points kept;
  std::vector<std::int32_t> kept_label;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_crumb(label[i])) continue;
    kept.push_back(points[i]);
    kept_label.push_back(label[i]);
  }
  if (kept.empty() || kept.size() == points.size()) return;
  const KdTree tree(kept);
  std::vector<KdTree::Neighbor> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_crumb(label[i])) continue;
    tree.Nearest(points[i], 1, found);
    label[i] = kept_label[found.front().index];
  }
}

// Numbers the parts by falling size from 1, ties by their first point; the core stays 0.
void NumberBySize(std::vector<std::int32_t>& label) {
  const auto count = CountLabels(label);
  std::vector<std::int32_t> order;  // by first point
  std::vector<bool> seen(count.size(), false);
  for (const std::int32_t l : label) {
    if (l == 0 || seen[static_cast<std::size_t>(l)]) continue;
    seen[static_cast<std::size_t>(l)] = true;
    order.push_back(l);
  }
  std::ranges::stable_sort(order, [&](std::int32_t a, std::int32_t b) {
    return count[static_cast<std::size_t>(a)] > count[static_cast<std::size_t>(b)];
  });
  std::vector<std::int32_t> number(count.size(), 0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    number[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k) + 1;
  }
  for (std::int32_t& l : label) l = number[static_cast<std::size_t>(l)];
}

std::vector<std::uint32_t> InOrder(const std::vector<std::uint32_t>& values,
                                   const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> ordered;
  for (const std::uint32_t i : order) ordered.push_back(values[i]);
  return ordered;
}

// Section 6.2.2 for clouds: flood filling of what remains at d < d_a.
std::vector<std::int32_t> FillCloud(const Shape& cloud, const std::vector<bool>& in_core) {
  std::vector<std::uint32_t> rest;
  for (std::uint32_t i = 0; i < in_core.size(); ++i) {
    if (!in_core[i]) rest.push_back(i);
  }
  std::vector<std::int32_t> label(in_core.size(), 0);
  if (rest.empty()) return label;
  rest = InOrder(rest, SpatialOrder(geometry::Select(cloud.points, rest)));
  const Points points = geometry::Select(cloud.points, rest);
  const KdTree tree(points);
  struct Link {
    std::uint32_t a, b;
    double squared;
  };
  std::vector<Link> links;
  std::vector<double> reach;  // to the last of a point's neighbours, squared
  std::vector<KdTree::Neighbor> found;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Nearest(points[i], kNeighbors + 1, found);
    for (const auto& n : found) {
      if (n.index != i) links.push_back({i, n.index, n.squared_distance});
    }
    reach.push_back(found.back().squared_distance);
    sum += std::sqrt(reach.back());
  }
  const double d_a = sum / static_cast<double>(points.size()) * (1.0 + 1e-9);
  geometry::UnionFind sets(points.size());
  for (const Link& link : links) {
    if (link.squared <= std::max(d_a * d_a, reach[link.b])) sets.Unite(link.a, link.b);
  }
  std::vector<std::int32_t> piece;
  geometry::LabelBySize(sets, std::vector<bool>(points.size(), true), piece);
  for (std::size_t k = 0; k < rest.size(); ++k) label[rest[k]] = piece[k] + 1;
  JoinCrumbs(cloud.points, label);
  NumberBySize(label);
  return label;
}

// Section 6.2.2 for meshes: faces that share an edge.
std::vector<std::int32_t> FillMesh(const Shape& mesh, const std::vector<bool>& in_core) {
  const FaceGraph graph = BuildFaceGraph(mesh);
  geometry::UnionFind sets(mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (in_core[f]) continue;
    for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
      if (!in_core[graph.neighbor[k]]) sets.Unite(f, graph.neighbor[k]);
    }
  }
  std::vector<bool> rest(in_core.size());
  for (std::size_t f = 0; f < rest.size(); ++f) rest[f] = !in_core[f];
  std::vector<std::int32_t> label;
  geometry::LabelBySize(sets, rest, label);
  for (std::int32_t& l : label) ++l;
  return label;
}

}  // namespace

Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere) {
  const Eigen::Vector3d d = p - sphere.center;
  const double radius = d.norm();
  if (!(radius > 0.0)) return sphere.center + Eigen::Vector3d(2.0 * sphere.radius, 0.0, 0.0);
  return p + 2.0 * (sphere.radius - radius) * d / radius;
}

Eigen::Vector3d MirrorIn(const Eigen::Vector3d& mirrored, const Sphere& sphere, double offset) {
  const Eigen::Vector3d d = mirrored - sphere.center;
  const double radius = d.norm();
  return mirrored + 2.0 * (sphere.radius + offset - radius) * d / radius;
}

double Offset(const Eigen::Vector3d& p, std::span<const Eigen::Vector3d> neighbors,
              const Eigen::Vector3d& center) {
  if (neighbors.empty()) return 0.0;
  const double radius = (p - center).norm();
  double sum = 0.0;
  for (const Eigen::Vector3d& n : neighbors) sum += std::abs((n - center).norm() - radius);
  return sum / static_cast<double>(neighbors.size());
}

double BoundingRadius(geometry::PointSpan points, const Eigen::Vector3d& center) {
  double square = 0.0;
  for (const Eigen::Vector3d& p : points) square = std::max(square, (p - center).squaredNorm());
  return std::sqrt(square);
}

std::optional<Core> ExtractCore(const Shape& shape, const MirrorOptions& options) {
  Core core;
  if (!FindCenter(shape, options, core)) return std::nullopt;
  const Sphere sphere{core.center, BoundingRadius(shape.points, core.center)};
  Points images;
  images.reserve(shape.points.size());
  for (const Eigen::Vector3d& p : shape.points) images.push_back(MirrorOut(p, sphere));
  core.hull_points = HullPoints(images, core.center);
  const auto offsets = shape.IsMesh() ? MeshOffsets(shape, core.hull_points, core.center)
                                      : CloudOffsets(shape, core.hull_points, core.center);
  Points back;
  for (std::size_t k = 0; k < core.hull_points.size(); ++k) {
    back.push_back(MirrorIn(images[core.hull_points[k]], sphere, offsets[k]));
  }
  core.inside.assign(shape.points.size(), false);
  const HullSide inner(HullOf(back), core.center);  // eq. 6.6
  HullSide::Hint hint;
  for (const std::uint32_t i : SpatialOrder(shape.points)) {
    core.inside[i] = inner.Contains(shape.points[i], hint);
  }
  // Their own images span the hull, whatever rounding says (and if it is flat, they are all).
  for (const std::uint32_t i : core.hull_points) core.inside[i] = true;
  return core;
}

Segmentation SegmentByMirroring(const Shape& shape, const MirrorOptions& options) {
  const auto core = ExtractCore(shape, options);
  if (!core) {
    throw core::InputError(
        "neither the centre of the smallest enclosing sphere nor the centre of gravity is inside; "
        "go_on_outside segments nevertheless");
  }
  const auto in_core = CoreElements(shape, *core);
  Segmentation result;
  result.label = shape.IsMesh() ? FillMesh(shape, in_core) : FillCloud(shape, in_core);
  result.has_core = std::find(result.label.begin(), result.label.end(), 0) != result.label.end();
  if (!result.has_core) {
    for (std::int32_t& l : result.label) --l;
  }
  result.parts = 1 + *std::max_element(result.label.begin(), result.label.end());
  if (!core->center_inside) {
    result.note = "no centre inside was found; mirrored at that of the smallest enclosing sphere";
  } else if (core->used_centroid) {
    result.note =
        "the centre of the smallest enclosing sphere is outside; mirrored at the centre "
        "of gravity";
  }
  return result;
}

}  // namespace rangegrasp::parts
