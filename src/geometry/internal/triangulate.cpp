#include "geometry/internal/triangulate.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>

namespace rangegrasp::geometry::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
// Whether a face is inside of the polygon: -1 not yet known.
using Face = CGAL::Constrained_triangulation_face_base_2<
    Kernel, CGAL::Triangulation_face_base_with_info_2<int, Kernel>>;
using Plane =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel,
                                               CGAL::Triangulation_data_structure_2<Vertex, Face>,
                                               CGAL::No_constraint_intersection_tag>;
using Corners = std::span<const std::uint32_t>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Newell: its length is twice the area.
Eigen::Vector3d NormalOf(const Points& points, Corners corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& origin = points[corners[0]];
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    normal += (points[corners[k]] - origin).cross(points[corners[k + 1]] - origin);
  }
  return normal;
}

void AppendFan(Corners corners, std::size_t from, Triangles& triangles) {
  const std::size_t n = corners.size();
  for (std::size_t k = 1; k + 1 < n; ++k) {
    triangles.push_back({corners[from], corners[(from + k) % n], corners[(from + k + 1) % n]});
  }
}

// The corner at which the polygon turns the other way; 0 if there is none.
std::size_t HollowCorner(const Points& points, Corners corners, const Eigen::Vector3d& normal) {
  const std::size_t n = corners.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d& p = points[corners[k]];
    const Eigen::Vector3d before = p - points[corners[(k + n - 1) % n]];
    if (before.cross(points[corners[(k + 1) % n]] - p).dot(normal) < 0.0) return k;
  }
  return 0;
}

// Faces on the same side of the border as `face`, with each crossing of it the other way round.
void TellInside(Plane& plane) {
  std::vector<std::pair<Plane::Face_handle, int>> open = {{plane.infinite_face(), 0}};
  while (!open.empty()) {
    const auto [face, inside] = open.back();
    open.pop_back();
    if (face->info() != -1) continue;
    face->info() = inside;
    for (int i = 0; i < 3; ++i) {
      open.emplace_back(face->neighbor(i), plane.is_constrained({face, i}) ? 1 - inside : inside);
    }
  }
}

Plane Triangulated(const Points& points, Corners corners, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d x = normal.unitOrthogonal();
  const Eigen::Vector3d y = normal.cross(x);
  Plane plane;
  std::vector<Plane::Vertex_handle> handles;
  for (const std::uint32_t c : corners) {
    const Eigen::Vector3d p = points[c] - points[corners[0]];
    const Plane::Face_handle near = handles.empty() ? Plane::Face_handle() : handles.back()->face();
    handles.push_back(plane.insert(Kernel::Point_2(p.dot(x), p.dot(y)), near));
    handles.back()->info() = c;
  }
  for (std::size_t k = 0; k < handles.size(); ++k) {
    const auto& next = handles[(k + 1) % handles.size()];
    if (handles[k] != next) plane.insert_constraint(handles[k], next);
  }
  for (const auto& face : plane.all_face_handles()) face->info() = -1;
  return plane;
}

// @return whether the polygon is simple, so that it was cut.
bool AppendDelaunay(const Points& points, Corners corners, const Eigen::Vector3d& normal,
                    Triangles& triangles) {
  const std::size_t before = triangles.size();
  try {
    Plane plane = Triangulated(points, corners, normal);
    if (plane.dimension() < 2) return false;
    TellInside(plane);
    for (const auto& face : plane.finite_face_handles()) {
      if (face->info() != 1) continue;
      triangles.push_back(
          {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
    }
  } catch (const Plane::Intersection_of_constraints_exception&) {
    return false;
  }
  if (triangles.size() - before == corners.size() - 2) return true;
  triangles.resize(before);
  return false;
}

}  // namespace

void AppendTriangles(const Points& points, Corners corners, Triangles& triangles) {
  if (corners.size() <= 3) return AppendFan(corners, 0, triangles);
  const Eigen::Vector3d normal = NormalOf(points, corners);
  if (!(normal.norm() > 0.0) || !normal.allFinite()) return AppendFan(corners, 0, triangles);
  const std::size_t hollow = HollowCorner(points, corners, normal);
  if (corners.size() == 4) return AppendFan(corners, hollow, triangles);
  if (AppendDelaunay(points, corners, normal.normalized(), triangles)) return;
  AppendFan(corners, hollow, triangles);
}

}  // namespace rangegrasp::geometry::internal
