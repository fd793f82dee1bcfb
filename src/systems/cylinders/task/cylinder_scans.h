#pragma once

#include "base/rng.h"
#include "geometry/point_cloud.h"
#include "sensing/range_sensor.h"

namespace rangegrasp::cylinders {

/// A cylinder along x with its center at the origin, as in table 4.3: v = (1, 0, 0). The end at +x
/// is the upper one.
struct CylinderShape {
  double radius_m = 0.010;
  double height_m = 0.100;
};

/// Distance of the sensor from the cylinder's center: the scanner's focus distance.
inline constexpr double kSensorDistance_m = 0.9;
/// Position of the sensor: it lies in the plane of x and z, on the side of +z, and looks down at
/// the cylinder's center by 37 deg, like the dissertation's.
Eigen::Vector3d SensorPosition();

/// The points of a 2.5-D range image of the cylinder alone, in its frame: rays on a square grid of
/// view angles with random phase, spaced so that they give the requested number of points (the few
/// excess points are removed evenly). Each point is moved along its ray by normally distributed
/// noise. Scan lines run up and down.
geometry::Points SyntheticScan(const CylinderShape& shape, int points, double noise_m,
                               base::Rng& rng);

/// Keeps `wanted` of the points, evenly spaced in their order; all if there are no more.
void KeepEvenly(int wanted, geometry::Points& points);

/// All points that the line scanner measures of a cylinder above the table on which it stands, in
/// the cylinder's frame. The scanner has all its errors except the calibration error, which would
/// turn every fit's axis equally. Its fan and sweep cover the cylinder, its spacing is adapted to
/// give the requested number of points, and the few excess points are removed.
/// @throws base::InputError if the scanner cannot measure that many points.
geometry::Points ScanCylinder(const CylinderShape& shape, int points,
                              sensing::LineScannerOptions scanner, base::Rng& rng);

}  // namespace rangegrasp::cylinders
