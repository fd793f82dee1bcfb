#include "parts/mirror/mirror_core.h"

#include <algorithm>
#include <tuple>

#include "geometry/hull.h"
#include "geometry/kd_tree.h"
#include "parts/mirror/inside.h"
#include "parts/mirror/internal/hull_side.h"
#include "parts/mirror/internal/space.h"
#include "parts/mirror/spherical_mirror.h"

namespace rangegrasp::parts {
namespace {

using geometry::KdTree;
using geometry::Points;

// ---- eq. 6.3: which images the outer hull consists of ----

// The farthest image in each of 384 directions: their hull holds most of the others.
Points Farthest(const Points& images, const Eigen::Vector3d& center) {
  // Cells along a side of the cube of directions: the hull of more costs more to make, that of
  // fewer holds less. The core does not depend on it.
  constexpr int kSide = 8;
  constexpr std::uint32_t kNoFace = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> best(static_cast<std::size_t>(6 * kSide * kSide), kNoFace);
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
    if (i != kNoFace) farthest.push_back(images[i]);
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

}  // namespace

std::optional<Core> ExtractCore(const Shape& shape, const MirrorOptions& options) {
  Core core;
  if (!FindCenter(shape, options, core)) return std::nullopt;
  const Sphere sphere = SphereRound(core.center, shape.points);
  const Points images = MirrorOut(shape.points, sphere);
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

}  // namespace rangegrasp::parts
