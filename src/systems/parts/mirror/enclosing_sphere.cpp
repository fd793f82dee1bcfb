#include "parts/mirror/enclosing_sphere.h"

#include <CGAL/Min_sphere_of_points_d_traits_3.h>
#include <CGAL/Min_sphere_of_spheres_d.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace rangegrasp::parts {

Sphere SmallestEnclosingSphere(geometry::PointSpan points) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Traits = CGAL::Min_sphere_of_points_d_traits_3<Kernel, double>;
  if (points.empty()) throw std::invalid_argument("SmallestEnclosingSphere: needs a point");
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  CGAL::Min_sphere_of_spheres_d<Traits> sphere(input.begin(), input.end());
  const double* center = sphere.center_cartesian_begin();
  return {{center[0], center[1], center[2]}, sphere.radius()};
}

Sphere SphereRound(const Eigen::Vector3d& center, geometry::PointSpan points) {
  double square = 0.0;
  for (const Eigen::Vector3d& p : points) square = std::max(square, (p - center).squaredNorm());
  return {center, std::sqrt(square)};
}

}  // namespace rangegrasp::parts
