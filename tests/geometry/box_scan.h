#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rng.h"
#include "geometry/observation.h"

namespace rangegrasp::geometry::samples {

/// Scan of a box on the table z = 0 by a point sensor at X_CS, ray by ray, with the same noise on
/// each range. An independent model of slabs and a plane; it uses no mesh and none of the project's
/// sensors.
inline View ScanBox(const base::Pose& X_CS, const Eigen::AlignedBox3d& box_C, double sigma_m,
                    base::Rng& rng, int side = 120, double half_rad = 0.35) {
  View view;
  view.X_CV = X_CS;
  view.image.profiles = view.image.samples = side;
  view.image.origins_C = {X_CS.translation()};
  const Eigen::Vector3d o = X_CS.translation();
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double y = std::tan(half_rad) * (2.0 * row / (side - 1) - 1.0);
      const double x = std::tan(half_rad) * (2.0 * column / (side - 1) - 1.0);
      const Eigen::Vector3d d = X_CS.linear() * Eigen::Vector3d(x, y, 1.0).normalized();
      double range = d.z() < 0.0 ? -o.z() / d.z() : std::numeric_limits<double>::infinity();
      const Eigen::Array3d a = (box_C.min() - o).array() / d.array();
      const Eigen::Array3d b = (box_C.max() - o).array() / d.array();
      const double enter = a.min(b).maxCoeff();
      const double leave = a.max(b).minCoeff();
      if (enter > 0.0 && enter < leave) range = std::min(range, enter);
      const Eigen::Vector3d point = o + (range + sigma_m * rng.Normal()) * d;
      view.image.points_C.push_back(
          std::isfinite(range)
              ? point
              : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
      view.noise_m.push_back(static_cast<float>(sigma_m));
    }
  }
  return view;
}

/// Pose of a sensor at from_C that looks at at_C.
inline base::Pose LookFrom(const Eigen::Vector3d& from_C, const Eigen::Vector3d& at_C) {
  const Eigen::Vector3d z = (at_C - from_C).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return base::MakePose(R, from_C);
}

}  // namespace rangegrasp::geometry::samples
