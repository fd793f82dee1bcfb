#include "cylinders/ray_noise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace rangegrasp::cylinders {

Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector3d& d = barrel.axis.direction;
  const Eigen::Vector3d ray = (p - eye).stableNormalized();
  const Eigen::Vector3d across = ray - ray.dot(d) * d;
  const double length = across.norm();
  if (length == 0.0) return {0.0, 0.0};
  // The ray's distance from the axis, as a share of the radius: the sine of its incidence in the
  // section square to the axis.
  const double sine = std::min(
      1.0, std::abs((barrel.axis.point - eye).dot(across.cross(d))) / (length * barrel.radius_m));
  return {length * std::sqrt(1.0 - sine * sine), length * sine};
}

DistanceNoise DistanceNoiseOf(const RayNoise& noise, const Incidence& incidence, double radius_m) {
  const auto mixed = [&noise](double part) {
    return std::pow(noise.along_m * part, 2) + std::pow(noise.across_m, 2) * (1.0 - part * part);
  };
  const double tangential_m2 = mixed(incidence.tangential);
  return {tangential_m2 / (2.0 * radius_m),
          mixed(incidence.radial) + std::pow(tangential_m2 / radius_m, 2) / 2.0};
}

}  // namespace rangegrasp::cylinders
