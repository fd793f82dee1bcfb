#include "grasp/obstacles.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "geometry/bounds.h"
#include "geometry/groups.h"
#include "geometry/hull.h"
#include "geometry/kd_tree.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;
using geometry::Points;

/// Shadows start this far behind the surface that throws them: the surface itself is an obstacle
/// already, and what leans on it need not be moved through its noise.
constexpr double kBehind_m = 0.002;
/// Where a shadow's ray hardly goes down, it ends here: beyond a table.
constexpr double kMaxShadow_m = 2.0;

/// Points above the table's clearance that no object holds.
Points LeftoverPoints(const perception::Scene& scene) {
  std::vector<char> known(scene.points_C.size(), 0);
  for (const auto i : scene.table.points) known[i] = 1;
  for (const auto& object : scene.objects) {
    for (const auto i : object.points) known[scene.source[i]] = 1;
  }
  Points leftover;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!known[i]) leftover.push_back(scene.points_C[i]);
  }
  return leftover;
}

Points DirectionsFrom(const Vector3d& place_C, const Points& points) {
  Points directions;
  directions.reserve(points.size());
  for (const Vector3d& p : points) directions.push_back((p - place_C).normalized());
  return directions;
}

/// Drops the points that are seen beside an object's.
void DropMixed(const perception::Scene& scene, const Points& places_C, double width_m,
               Points& points) {
  Points of_objects;
  for (const auto& object : scene.objects) {
    for (const auto i : object.points) of_objects.push_back(scene.points_C[scene.source[i]]);
  }
  if (of_objects.empty()) return;
  for (const Vector3d& place_C : places_C) {
    const Points directions = DirectionsFrom(place_C, of_objects);
    const geometry::KdTree tree(directions);
    std::vector<geometry::KdTree::Neighbor> nearest;
    std::erase_if(points, [&](const Vector3d& p) {
      const double distance_m = (p - place_C).norm();
      tree.Within((p - place_C) / distance_m, width_m / distance_m, nearest);
      return !nearest.empty();
    });
  }
}

/// Whether a group is so near to the target, and so small, that it is a part of it, for all that
/// can be seen: a corner that lost points have cut off. It goes with the target.
bool IsPartOf(const geometry::KdTree& target, double target_extent_m, const Points& group,
              double link_m) {
  if (geometry::BoundsOf(group).diagonal().norm() >= target_extent_m) return false;
  std::vector<geometry::KdTree::Neighbor> near;
  return std::any_of(group.begin(), group.end(), [&](const Vector3d& p) {
    target.Within(p, link_m, near);
    return !near.empty();
  });
}

/// The points that lie furthest along the 26 directions of a cube's faces, edges and corners. Their
/// hull misses at most 8 % of the radius of that of all, less than a point spacing in a cell, and
/// is found several times faster.
Points Outermost(const Points& points) {
  std::set<std::size_t> found;
  for (int k = 0; k < 27; ++k) {
    const Vector3d direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    const auto furthest = std::max_element(
        points.begin(), points.end(),
        [&](const Vector3d& p, const Vector3d& q) { return p.dot(direction) < q.dot(direction); });
    found.insert(static_cast<std::size_t>(furthest - points.begin()));
  }
  return geometry::Select(points, geometry::Indices(found.begin(), found.end()));
}

/// The hull of boxes of an edge about the points.
geometry::TriangleMesh HullAbout(const Points& points, double edge_m) {
  Points corners;
  for (const Vector3d& p : points) {
    for (int k = 0; k < 8; ++k) {
      corners.push_back(
          p + 0.5 * edge_m * Vector3d(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0));
    }
  }
  return geometry::ConvexHull(corners);
}

/// What the points of a thing that need not be convex, as a box that is open, fill: a hull about
/// those of each cell.
geometry::TriangleMesh FilledCells(const Points& points, double cell_m, double edge_m) {
  std::map<std::array<long, 3>, Points> cells;
  for (const Vector3d& p : points) cells[GridCell(p, cell_m)].push_back(p);
  geometry::TriangleMesh filled;
  for (const auto& [cell, inside] : cells) {
    geometry::Append(HullAbout(Outermost(inside), edge_m), filled);
  }
  return filled;
}

/// The space between a surface and its shadow on the table, seen from a place.
geometry::TriangleMesh ShadowOf(const geometry::TriangleMesh& surface_C, const Vector3d& place_C,
                                const geometry::Plane& table) {
  Points corners;
  for (const Vector3d& vertex : surface_C.vertices) {
    const Vector3d away = (vertex - place_C).normalized();
    const double down = -away.dot(table.normal);
    const double height_m = std::max(0.0, table.Distance(vertex));
    const double way_m = down > 0.0 ? std::min(height_m / down, kMaxShadow_m) : kMaxShadow_m;
    corners.push_back(vertex + std::min(kBehind_m, way_m) * away);
    corners.push_back(vertex + way_m * away);
  }
  return geometry::ConvexHull(corners);
}

void AddIfSolid(geometry::TriangleMesh mesh, std::vector<geometry::TriangleMesh>& meshes) {
  if (!mesh.triangles.empty()) meshes.push_back(std::move(mesh));
}

}  // namespace

Obstacles ObstaclesOf(const perception::Scene& scene, std::size_t target,
                      const geometry::Points& places_C, const ObstacleOptions& options) {
  Obstacles obstacles;
  const double gap_m = scene.sampling.gap_m;
  if (options.leftovers && gap_m > 0.0) {
    Points leftover = LeftoverPoints(scene);
    DropMixed(scene, places_C, options.mixed_gaps * gap_m, leftover);
    const double link_m = options.link_gaps * gap_m;
    const Points& target_C = scene.objects[target].completed_C;
    const geometry::KdTree of_target(target_C);
    const double target_extent_m = geometry::BoundsOf(target_C).diagonal().norm();
    for (const Points& group : geometry::GroupsWithin(leftover, link_m)) {
      if (group.size() < static_cast<std::size_t>(options.min_points)) continue;
      if (IsPartOf(of_target, target_extent_m, group, link_m)) continue;
      AddIfSolid(FilledCells(group, options.cell_m, gap_m), obstacles.measured_C);
    }
  }
  if (!options.unseen) return obstacles;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (i == target) continue;
    for (const Vector3d& place_C : places_C) {
      AddIfSolid(ShadowOf(scene.objects[i].surface_C, place_C, scene.table.plane),
                 obstacles.unseen_C);
    }
  }
  return obstacles;
}

}  // namespace rangegrasp::grasp
