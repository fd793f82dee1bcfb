#include "cylinders/fit.h"

#include <Eigen/Geometry>
#include <cmath>

namespace rangegrasp::cylinders {

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // Of a cosine alone angles below 1e-8 would be lost.
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

}  // namespace rangegrasp::cylinders
