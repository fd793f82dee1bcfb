#include "parts/mirror/spherical_mirror.h"

#include <cmath>

namespace rangegrasp::parts {

Eigen::Vector3d MirrorOut(const Eigen::Vector3d& p, const Sphere& sphere) {
  const Eigen::Vector3d d = p - sphere.center;
  const double radius = d.norm();
  if (!(radius > 0.0)) return sphere.center + Eigen::Vector3d(2.0 * sphere.radius, 0.0, 0.0);
  return p + 2.0 * (sphere.radius - radius) * d / radius;
}

geometry::Points MirrorOut(geometry::PointSpan points, const Sphere& sphere) {
  geometry::Points images;
  images.reserve(points.size());
  for (const Eigen::Vector3d& p : points) images.push_back(MirrorOut(p, sphere));
  return images;
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

}  // namespace rangegrasp::parts
