#include "geometry/mass_properties.h"

namespace rangegrasp::geometry {

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

}  // namespace rangegrasp::geometry
