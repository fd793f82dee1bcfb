#pragma once

#include "base/rng.h"
#include "geometry/point_cloud.h"
#include "sensing/range_sensor.h"

namespace rangegrasp::cylinders {

/// A cylinder along x with its center at the origin: v = (1, 0, 0) (table 4.3). +x is up.
struct CylinderShape {
  double radius_m = 0.010;
  double height_m = 0.100;
};

/// Distance of the sensor from the cylinder's center: the scanner's focus distance.
inline constexpr double kSensorDistance_m = 0.9;
/// In the plane of x and z, on the side of +z, looking down at the cylinder's center by 37 deg.
Eigen::Vector3d SensorPosition();

/// A 2.5-D range image of the cylinder alone, in its frame: rays on a square grid of view angles
/// with random phase that give the requested number of points (the few excess points are removed
/// evenly), with normally distributed noise along the rays. Scan lines run up and down.
geometry::Points SyntheticScan(const CylinderShape& shape, int points, double noise_m,
                               base::Rng& rng);

/// Keeps `wanted` of the points, evenly spaced in their order; all if there are no more.
void KeepEvenly(int wanted, geometry::Points& points);

/// The points that the line scanner measures of a cylinder standing on a table, in the cylinder's
/// frame, without the calibration error, which would turn every fit's axis equally. Its fan and
/// sweep cover the cylinder, and its spacing gives the requested number of points as above.
/// @throws base::InputError if the scanner cannot measure that many points.
geometry::Points ScanCylinder(const CylinderShape& shape, int points,
                              sensing::LineScannerOptions scanner, base::Rng& rng);

}  // namespace rangegrasp::cylinders
