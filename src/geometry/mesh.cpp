#include "geometry/mesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <iterator>

#include "geometry/graph.h"
#include "geometry/plane.h"

namespace rangegrasp::geometry {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Halfedge = SurfaceMesh::Halfedge_index;
using Vertex = SurfaceMesh::Vertex_index;

bool Coplanar(const SurfaceMesh& hull, Halfedge h) {
  return CGAL::coplanar(hull.point(hull.source(h)), hull.point(hull.target(h)),
                        hull.point(hull.target(hull.next(h))),
                        hull.point(hull.target(hull.next(hull.opposite(h)))));
}

/// The facet of each triangle: neighboring triangles in exactly one plane form one facet.
std::vector<std::uint32_t> FacetOfTriangle(const SurfaceMesh& hull) {
  UnionFind facets(hull.num_faces());
  for (const auto edge : hull.edges()) {
    const Halfedge h = hull.halfedge(edge);
    if (Coplanar(hull, h)) facets.Unite(hull.face(h), hull.face(hull.opposite(h)));
  }
  std::vector<std::uint32_t> facet(hull.num_faces());
  for (std::uint32_t f = 0; f < facet.size(); ++f) facet[f] = facets.Find(f);
  return facet;
}

/// The corners of a facet in order, starting at a triangle edge on its outline.
std::vector<Vertex> Corners(const SurfaceMesh& hull, const std::vector<std::uint32_t>& facet,
                            Halfedge start) {
  std::vector<Vertex> outline;
  Halfedge h = start;
  do {
    outline.push_back(hull.source(h));
    h = hull.next(h);
    while (facet[hull.face(h)] == facet[hull.face(hull.opposite(h))]) {
      h = hull.next(hull.opposite(h));
    }
  } while (h != start);
  std::vector<Vertex> corners;
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (!CGAL::collinear(hull.point(outline[(i + n - 1) % n]), hull.point(outline[i]),
                         hull.point(outline[(i + 1) % n]))) {
      corners.push_back(outline[i]);
    }
  }
  return corners;
}

std::vector<std::vector<Vertex>> Facets(const SurfaceMesh& hull) {
  const std::vector<std::uint32_t> facet = FacetOfTriangle(hull);
  std::vector<std::vector<Vertex>> facets;
  std::vector<bool> done(facet.size(), false);
  for (const Halfedge h : hull.halfedges()) {
    const std::uint32_t f = facet[hull.face(h)];
    if (done[f] || f == facet[hull.face(hull.opposite(h))]) continue;
    done[f] = true;
    facets.push_back(Corners(hull, facet, h));
  }
  return facets;
}

/// Appends the vertices that are corners of facets to the mesh, ascending by x, y, z.
/// @return the index of each in the mesh.
std::vector<std::uint32_t> AddVertices(const SurfaceMesh& hull,
                                       const std::vector<std::vector<Vertex>>& facets,
                                       TriangleMesh& mesh) {
  std::vector<std::uint32_t> number(hull.num_vertices(), 0);
  for (const auto& corners : facets) {
    for (const Vertex v : corners) number[v] = 1;
  }
  std::vector<Vertex> order;
  std::ranges::copy_if(hull.vertices(), std::back_inserter(order),
                       [&](Vertex v) { return number[v] == 1; });
  std::ranges::sort(order, [&](Vertex a, Vertex b) { return hull.point(a) < hull.point(b); });
  for (const Vertex v : order) {
    number[v] = static_cast<std::uint32_t>(mesh.vertices.size());
    const Kernel::Point_3& p = hull.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  return number;
}

}  // namespace

TriangleMesh Transformed(const TriangleMesh& mesh_B, const base::Pose& X_AB) {
  TriangleMesh mesh_A = mesh_B;
  for (Eigen::Vector3d& p : mesh_A.vertices) p = X_AB * p;
  return mesh_A;
}

void Append(const TriangleMesh& other, TriangleMesh& mesh) {
  const auto shift = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + shift, b + shift, c + shift});
  }
}

double Volume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  // A reference point on the mesh keeps the terms small for meshes far from the origin.
  const Eigen::Vector3d origin = mesh.vertices.front();
  double six_volumes = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d u = mesh.vertices[a] - origin;
    const Eigen::Vector3d v = mesh.vertices[b] - origin;
    const Eigen::Vector3d w = mesh.vertices[c] - origin;
    six_volumes += u.dot(v.cross(w));
  }
  return six_volumes / 6.0;
}

MassProperties MassPropertiesOf(const TriangleMesh& mesh) {
  MassProperties result{0.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  if (mesh.vertices.empty()) return result;
  // A reference point on the mesh keeps the terms small for meshes far from the origin.
  const Eigen::Vector3d origin = mesh.vertices.front();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& [i, j, k] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[i] - origin;
    const Eigen::Vector3d b = mesh.vertices[j] - origin;
    const Eigen::Vector3d c = mesh.vertices[k] - origin;
    const Eigen::Vector3d s = a + b + c;
    const double volume = a.dot(b.cross(c)) / 6.0;
    result.volume_m3 += volume;
    first += volume / 4.0 * s;
    second += volume / 20.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  result.center_M = origin;
  if (result.volume_m3 == 0.0) return result;
  const Eigen::Vector3d center = first / result.volume_m3;
  result.center_M += center;
  second -= result.volume_m3 * center * center.transpose();
  result.inertia_M = second.trace() * Eigen::Matrix3d::Identity() - second;
  return result;
}

// CGAL's triangles of a facet with more than three corners, and their order, depend on memory
// addresses. The solid itself does not: its facets are recovered, each is cut into a fan from its
// first corner, and vertices and triangles are sorted.
TriangleMesh ConvexHull(PointSpan points) {
  TriangleMesh mesh;
  if (points.size() < 4 || IsFlat(points)) return mesh;
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  SurfaceMesh hull;
  CGAL::convex_hull_3(input.begin(), input.end(), hull);
  std::vector<std::vector<Vertex>> facets = Facets(hull);
  const std::vector<std::uint32_t> number = AddVertices(hull, facets, mesh);
  for (auto& corners : facets) {
    std::ranges::rotate(corners,
                        std::ranges::min_element(corners, {}, [&](Vertex v) { return number[v]; }));
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh.triangles.push_back({number[corners[0]], number[corners[i - 1]], number[corners[i]]});
    }
  }
  std::ranges::sort(mesh.triangles);
  return mesh;
}

}  // namespace rangegrasp::geometry
