#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::testing_support {

/// A cylinder along x about the origin, and points of it that an eye at +z sees.
struct SeenCylinder {
  double radius_m = 0.02;
  double height_m = 0.1;
  Eigen::Vector3d eye = Eigen::Vector3d(0.5, 0.0, 0.7);

  /// Rows along the wall's seen side, the outline left out, and rings over the upper end (+x). Each
  /// point is moved along its ray by noise.
  geometry::Points Points(int rows, int columns, bool end, double noise_m, base::Rng& rng) const {
    geometry::Points points;
    const double half_angle = std::acos(radius_m / eye.z()) - base::Deg(3.0);
    for (int i = 0; i < rows; ++i) {
      for (int k = 0; k < columns; ++k) {
        const double x = height_m * ((i + 0.5) / rows - 0.5);
        const double angle = half_angle * (2.0 * (k + 0.5) / columns - 1.0);
        points.emplace_back(x, radius_m * std::sin(angle), radius_m * std::cos(angle));
      }
    }
    for (int i = 0; end && i < rows / 2; ++i) {
      for (int k = 0; k < columns; ++k) {
        const double r = radius_m * std::sqrt((i + 0.5) / (rows / 2));
        const double angle = 2.0 * base::kPi * k / columns;
        points.emplace_back(0.5 * height_m, r * std::sin(angle), r * std::cos(angle));
      }
    }
    for (auto& p : points) {
      const double noise = noise_m * rng.Normal();
      p += noise * (p - eye).normalized();
    }
    return points;
  }
};

/// A pose that is none of the axes'.
inline base::Pose SomePose() {
  return base::MakePose(
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix(),
      {0.3, -0.2, 0.9});
}

}  // namespace rangegrasp::testing_support
