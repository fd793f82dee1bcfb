#include "mesh/poisson.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/poisson_surface_reconstruction.h>

#include <stdexcept>
#include <utility>

namespace rangegrasp::geometry {
namespace {

using PoissonKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Oriented = std::pair<PoissonKernel::Point_3, PoissonKernel::Vector_3>;
using PoissonMesh = CGAL::Surface_mesh<PoissonKernel::Point_3>;

constexpr std::size_t kMinPoints = 100;
// CGAL's own choice of the least angle; triangles as large as two thirds of what it takes, for
// small things; see PoissonSurface.
constexpr double kMinAngle_deg = 20.0;
constexpr double kMaxRadius = 20.0;
constexpr double kMaxDistance = 0.25;

TriangleMesh MeshOf(const PoissonMesh& surface) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> position(surface.number_of_vertices() +
                                      surface.number_of_removed_vertices());
  for (const auto v : surface.vertices()) {
    position[v.idx()] = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto& p = surface.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : surface.faces()) {
    std::array<std::uint32_t, 3> corners{};
    std::size_t k = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f)))
      corners[k++] = position[v.idx()];
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

}  // namespace

std::optional<TriangleMesh> PoissonSurface(const PointCloud& cloud, double spacing_m) {
  if (cloud.points.size() != cloud.normals.size() || cloud.size() < kMinPoints) {
    throw std::invalid_argument("PoissonSurface: needs 100 points or more, and a normal for each");
  }
  std::vector<Oriented> oriented;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d& p = cloud.points[i];
    const Eigen::Vector3d& n = cloud.normals[i];
    oriented.emplace_back(PoissonKernel::Point_3(p.x(), p.y(), p.z()),
                          PoissonKernel::Vector_3(n.x(), n.y(), n.z()));
  }
  // The mesher starts from points drawn from CGAL's own generator, which the clock would seed.
  CGAL::get_default_random() = CGAL::Random(0);
  PoissonMesh surface;
  const bool found = CGAL::poisson_surface_reconstruction_delaunay(
      oriented.begin(), oriented.end(), CGAL::First_of_pair_property_map<Oriented>(),
      CGAL::Second_of_pair_property_map<Oriented>(), surface, spacing_m, kMinAngle_deg, kMaxRadius,
      kMaxDistance);
  if (!found || surface.number_of_faces() == 0) return std::nullopt;
  TriangleMesh mesh = MeshOf(surface);
  if (Volume(mesh) < 0.0) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

}  // namespace rangegrasp::geometry
