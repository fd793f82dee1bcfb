#include "grasp/obstacles.h"

#include <map>
#include <set>

#include "grasp/detector.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using geometry::KdTree;
using geometry::Observation;
using geometry::Points;
using geometry::Select;
using geometry::TriangleMesh;
using perception::Scene;

/// Shadows start this far behind the surface that casts them: the surface itself is already an
/// obstacle, and an object that leans on it need not be moved through its noise.
constexpr double kBehind_m = 0.002;
/// Maximum length of a shadow whose ray hardly descends: longer than a table.
constexpr double kMaxShadow_m = 2.0;

/// Points above the table's clearance that belong to no object.
Points LeftoverPoints(const Scene& scene) {
  std::vector<bool> leftover(scene.points_C.size(), true);
  for (const auto i : scene.table.points) leftover[i] = false;
  for (const auto& object : scene.objects) {
    for (const auto i : object.points) leftover[scene.source[i]] = false;
  }
  return Select(scene.points_C, geometry::PositionsOf(leftover));
}

/// Drops the points that are next to an object's points, as seen from a sensor.
void DropMixed(const Scene& scene, const Points& places_C, double width_m, Points& points) {
  Points of_objects;
  for (const auto& object : scene.objects) {
    for (const auto i : object.points) of_objects.push_back(scene.points_C[scene.source[i]]);
  }
  if (of_objects.empty()) return;
  for (const Vector3d& place_C : places_C) {
    Points directions = of_objects;
    for (Vector3d& p : directions) p = (p - place_C).normalized();
    const KdTree tree(directions);
    std::erase_if(points, [&](const Vector3d& p) {
      const double distance_m = (p - place_C).norm();
      return tree.CountWithin((p - place_C) / distance_m, width_m / distance_m, 1) > 0;
    });
  }
}

/// Whether a group is so near to the target, and so small, that it is a corner cut off from it.
bool IsPartOf(const KdTree& target, double target_extent_m, const Points& group, double link_m) {
  if (geometry::BoundsOf(group).diagonal().norm() >= target_extent_m) return false;
  return std::ranges::any_of(
      group, [&](const Vector3d& p) { return target.CountWithin(p, link_m, 1) > 0; });
}

/// The outermost points in the directions of a cube's 26 faces, edges and corners. Their hull
/// misses at most 8 % of the radius, less than a point spacing in a cell, and is found several
/// times faster.
Points Outermost(const Points& points) {
  std::set<std::size_t> found;
  for (int k = 0; k < 27; ++k) {
    const Vector3d direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    const auto furthest =
        std::ranges::max_element(points, {}, [&](const Vector3d& p) { return p.dot(direction); });
    found.insert(static_cast<std::size_t>(furthest - points.begin()));
  }
  return Select(points, geometry::Indices(found.begin(), found.end()));
}

TriangleMesh HullAbout(const Points& points, double edge_m) {
  Points corners;
  for (const Vector3d& p : points) {
    for (int k = 0; k < 8; ++k) {
      corners.push_back(
          p + 0.5 * edge_m * Vector3d(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0));
    }
  }
  return geometry::ConvexHull(corners);
}

/// A hull about the points of each cell, because a thing need not be convex, e.g. an open box.
TriangleMesh FilledCells(const Points& points, double cell_m, double edge_m) {
  std::map<std::array<long, 3>, Points> cells;
  for (const Vector3d& p : points) cells[GridCell(p, cell_m)].push_back(p);
  TriangleMesh filled;
  for (const auto& [cell, inside] : cells) {
    geometry::Append(HullAbout(Outermost(inside), edge_m), filled);
  }
  return filled;
}

/// The space between a surface and its shadow on the table, cast from a sensor's position.
TriangleMesh ShadowOf(const TriangleMesh& surface_C, const Vector3d& place_C,
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

void AddIfSolid(TriangleMesh mesh, std::vector<TriangleMesh>& meshes) {
  if (!mesh.triangles.empty()) meshes.push_back(std::move(mesh));
}

struct Convex {
  AlignedBox3d bounds;
  std::vector<Eigen::Hyperplane<double, 3>> planes;

  explicit Convex(const TriangleMesh& mesh) : bounds(geometry::BoundsOf(mesh.vertices)) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& vertex : mesh.vertices) {
      middle += vertex / static_cast<double>(mesh.vertices.size());
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3d& on = mesh.vertices[a];
      const Vector3d normal = (mesh.vertices[b] - on).cross(mesh.vertices[c] - on).normalized();
      const double sign = normal.dot(middle - on) > 0.0 ? -1.0 : 1.0;
      planes.emplace_back(sign * normal, on);
    }
  }

  bool Contains(const Vector3d& p) const {
    return bounds.contains(p) && std::ranges::all_of(planes, [&](const auto& plane) {
             return plane.signedDistance(p) <= 0.0;
           });
  }
};

AlignedBox3d Measured(const Observation& observation) {
  AlignedBox3d bounds;
  for (const geometry::View& view : observation.views) {
    for (const Vector3d& p : view.image.points_C) {
      if (p.allFinite()) bounds.extend(p);
    }
  }
  return bounds;
}

void AddBox(const AlignedBox3d& box, TriangleMesh& mesh) {
  // Corners in Eigen's order: bit 0 is x, bit 1 is y, bit 2 is z.
  static constexpr std::uint32_t kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                  {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                  {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int k = 0; k < 8; ++k) {
    mesh.vertices.push_back(box.corner(static_cast<AlignedBox3d::CornerType>(k)));
  }
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({first + face[0], first + face[1], first + face[2]});
  }
}

/// Cells of unseen space: half of a finger's width, so that a finger fits between two cells.
constexpr double kCell_m = 0.010;

}  // namespace

double GapOf(const Scene& scene) {
  if (scene.sampling.gap_m > 0.0) return scene.sampling.gap_m;
  return perception::MeasureSampling(scene.cloud.points, {}).gap_m;
}

Obstacles ObstaclesOf(const Scene& scene, std::size_t target, const geometry::Points& places_C,
                      const ObstacleOptions& options) {
  Obstacles obstacles;
  Points leftover =
      options.leftovers ? LeftoverPoints(scene) : Select(scene.cloud.points, scene.container);
  const double gap_m = leftover.empty() ? 0.0 : GapOf(scene);
  if (gap_m > 0.0) {
    DropMixed(scene, places_C, options.mixed_gaps * gap_m, leftover);
    const double link_m = options.link_gaps * gap_m;
    const Points& target_C = scene.objects[target].completed_C;
    const KdTree of_target(target_C);
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

TriangleMesh UnseenByAll(const Observation& observation, std::span<const TriangleMesh> shadows_C,
                         double cell_m) {
  TriangleMesh unseen;
  std::vector<Convex> shadows;
  AlignedBox3d bounds;
  for (const auto& mesh : shadows_C) {
    shadows.emplace_back(mesh);
    bounds.extend(shadows.back().bounds);
  }
  bounds = bounds.intersection(Measured(observation));
  if (bounds.isEmpty() || bounds.sizes().minCoeff() < cell_m) return unseen;
  const geometry::SeenSpace space(bounds, cell_m, observation);
  const auto counts = [&](const Eigen::Vector3i& cell) {
    if (space.At(cell) != geometry::SeenSpace::Cell::kUnseen) return false;
    const Vector3d middle = space.MiddleOf(cell);
    return std::ranges::any_of(shadows, [&](const Convex& one) { return one.Contains(middle); });
  };
  const Vector3d half = Vector3d::Constant(0.5 * cell_m);
  for (int y = 0; y < space.Size().y(); ++y) {
    for (int x = 0; x < space.Size().x(); ++x) {
      AlignedBox3d column;  // of consecutive cells that count
      for (int z = 0; z <= space.Size().z(); ++z) {
        const Eigen::Vector3i cell(x, y, z);
        if (z < space.Size().z() && counts(cell)) {
          column.extend(space.MiddleOf(cell) - half).extend(space.MiddleOf(cell) + half);
        } else if (!column.isEmpty()) {
          AddBox(column, unseen);
          column.setEmpty();
        }
      }
    }
  }
  return unseen;
}

Obstacles ObstaclesOfViews(const Scene& scene, std::size_t target, const Observation& observation,
                           const ObstacleOptions& options) {
  Obstacles obstacles = ObstaclesOf(scene, target, PlacesOf(observation), options);
  if (observation.views.size() < 2 || obstacles.unseen_C.empty()) return obstacles;
  TriangleMesh unseen = UnseenByAll(observation, obstacles.unseen_C, kCell_m);
  obstacles.unseen_C.clear();
  AddIfSolid(std::move(unseen), obstacles.unseen_C);
  return obstacles;
}

}  // namespace rangegrasp::grasp
