#include "geometry/mesh.h"

namespace rangegrasp::geometry {

TriangleMesh Transformed(const TriangleMesh& mesh_B, const base::Pose& X_AB) {
  TriangleMesh mesh_A = mesh_B;
  for (Eigen::Vector3d& p : mesh_A.vertices) p = X_AB * p;
  return mesh_A;
}

void Append(const TriangleMesh& other, TriangleMesh& mesh) {
  // Sizes are taken first, so that a mesh may be appended to itself.
  const auto shift = static_cast<std::uint32_t>(mesh.vertices.size());
  const std::size_t vertices = other.vertices.size();
  const std::size_t triangles = other.triangles.size();
  mesh.vertices.reserve(mesh.vertices.size() + vertices);
  mesh.triangles.reserve(mesh.triangles.size() + triangles);
  for (std::size_t i = 0; i < vertices; ++i) mesh.vertices.push_back(other.vertices[i]);
  for (std::size_t i = 0; i < triangles; ++i) {
    const auto [a, b, c] = other.triangles[i];
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

}  // namespace rangegrasp::geometry
