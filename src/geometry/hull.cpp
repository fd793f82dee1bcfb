#include "geometry/hull.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/convex_hull_3.h>

#include "geometry/plane.h"

namespace rangegrasp::geometry {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Points whose thickness is below this share of their extent are in one plane.
constexpr double kFlat = 1e-9;

bool IsFlat(PointSpan points) {
  const auto plane = FitPlane(points);
  if (!plane) return true;
  Eigen::Vector3d low = points.front();
  Eigen::Vector3d high = low;
  double thickness = 0.0;
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    thickness = std::max(thickness, std::abs(plane->Distance(p)));
  }
  return thickness <= kFlat * (high - low).norm();
}

}  // namespace

TriangleMesh ConvexHull(PointSpan points) {
  TriangleMesh mesh;
  if (points.size() < 4 || IsFlat(points)) return mesh;
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  SurfaceMesh hull;
  CGAL::convex_hull_3(input.begin(), input.end(), hull);
  for (const auto vertex : hull.vertices()) {
    const Kernel::Point_3& p = hull.point(vertex);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : hull.faces()) {
    const auto h = hull.halfedge(face);
    mesh.triangles.push_back({static_cast<std::uint32_t>(hull.source(h)),
                              static_cast<std::uint32_t>(hull.target(h)),
                              static_cast<std::uint32_t>(hull.target(hull.next(h)))});
  }
  return mesh;
}

std::vector<Eigen::Vector2d> ConvexHull2(std::span<const Eigen::Vector2d> points) {
  std::vector<Kernel::Point_2> input;
  input.reserve(points.size());
  for (const Eigen::Vector2d& p : points) input.emplace_back(p.x(), p.y());
  std::vector<Kernel::Point_2> corners;
  CGAL::convex_hull_2(input.begin(), input.end(), std::back_inserter(corners));
  std::vector<Eigen::Vector2d> hull;
  hull.reserve(corners.size());
  for (const Kernel::Point_2& p : corners) hull.emplace_back(p.x(), p.y());
  return hull;
}

}  // namespace rangegrasp::geometry
