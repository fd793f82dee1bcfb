#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/cylinder.h"
#include "geometry/observation.h"

/// Simulated scan of a table with cylinders and boxes from one sensor position: rays on a regular
/// grid of directions, with white noise along each ray.
namespace rangegrasp::cylinders::samples {

struct Box {
  base::Pose X_WB = base::Pose::Identity();  ///< pose of the center
  Eigen::Vector3d size_m;
};

struct Tabletop {
  std::vector<Cylinder> cylinders;
  std::vector<Box> boxes;
};

struct Sensor {
  Eigen::Vector3d origin{0.75, 0.0, 0.75};
  Eigen::Vector3d target{0.0, 0.0, 0.0};
  int profiles = 220;
  int samples = 220;
  double field_rad = base::Deg(28.0);  ///< in both directions
  double noise_m = 0.0003;
};

/// The fraction of the way from the origin to p at which the ray meets a box.
inline std::optional<double> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& p,
                                     const Box& box) {
  const Eigen::Vector3d from = box.X_WB.inverse() * origin;
  const Eigen::Vector3d way = box.X_WB.linear().transpose() * (p - origin);
  double enters = 0.0;
  double leaves = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double half = 0.5 * box.size_m[k];
    const double one = (-half - from[k]) / way[k];
    const double other = (half - from[k]) / way[k];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  return enters < leaves && enters > 0.0 ? std::optional(enters) : std::nullopt;
}

/// The scan in the table's frame: the plane is z = 0, the origin is in its middle.
inline geometry::Observation Scan(const Tabletop& tabletop, const Sensor& sensor, base::Rng& rng) {
  geometry::RangeImage image{sensor.profiles, sensor.samples, {}, {sensor.origin}};
  const Eigen::Vector3d ahead = (sensor.target - sensor.origin).normalized();
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d up = right.cross(ahead);
  for (int row = 0; row < sensor.profiles; ++row) {
    for (int column = 0; column < sensor.samples; ++column) {
      const double a = sensor.field_rad * (row / (sensor.profiles - 1.0) - 0.5);
      const double b = sensor.field_rad * (column / (sensor.samples - 1.0) - 0.5);
      const Eigen::Vector3d ray = (ahead + std::tan(a) * right + std::tan(b) * up).normalized();
      double range_m = ray.z() < 0.0 ? -sensor.origin.z() / ray.z() : 100.0;
      const Eigen::Vector3d far = sensor.origin + range_m * ray;
      double share = 1.0;
      for (const Cylinder& cylinder : tabletop.cylinders) {
        if (const auto entry = cylinders::EntryOf(sensor.origin, far - sensor.origin, cylinder)) {
          share = std::min(share, entry->share);
        }
      }
      for (const Box& box : tabletop.boxes) {
        share = std::min(share, EntryOf(sensor.origin, far, box).value_or(1.0));
      }
      range_m = share * range_m + sensor.noise_m * rng.Normal();
      image.points_C.push_back(range_m < 3.0 ? Eigen::Vector3d(sensor.origin + range_m * ray)
                                             : Eigen::Vector3d::Constant(std::nan("")));
    }
  }
  return geometry::ObservationOf(std::move(image));
}

inline Cylinder Standing(double x, double y, double radius_m, double height_m) {
  return {{x, y, 0.5 * height_m}, Eigen::Vector3d::UnitZ(), radius_m, height_m};
}

/// @param turn_rad  rotation of the axis about the vertical, from x
inline Cylinder Lying(double x, double y, double turn_rad, double radius_m, double height_m) {
  return {{x, y, radius_m}, {std::cos(turn_rad), std::sin(turn_rad), 0.0}, radius_m, height_m};
}

inline Box StandingBox(double x, double y, double turn_rad, const Eigen::Vector3d& size_m) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {base::MakePose(turn, {x, y, 0.5 * size_m.z()}), size_m};
}

}  // namespace rangegrasp::cylinders::samples
