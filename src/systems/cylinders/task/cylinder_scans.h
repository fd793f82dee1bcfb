#pragma once

#include "cylinders/fit.h"
#include "sensing/line_scanner_options.h"

namespace rangegrasp::cylinders {

/// A cylinder along x with its center at the origin, as in table 4.3: v = (1, 0, 0). The end at +x
/// is the upper one.
struct CylinderShape {
  double radius_m = 0.010;
  double height_m = 0.100;
};

/// Viewpoint of the sensor: it lies in the plane of x and z, on the side of +z, and looks down at
/// the cylinder's center.
struct Viewpoint {
  double distance_m = 0.9;             ///< the scanner's focus distance
  double pitch_rad = base::Deg(37.0);  ///< the dissertation's, below the horizontal

  Eigen::Vector3d Eye() const;
};

/// The measured points of one cylinder, in the cylinder's frame.
struct CylinderView {
  geometry::Points points;  ///< [m], in the order of the scan
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();

  FitInput Input() const { return {points, eye, Eigen::Vector3d::UnitX()}; }
};

/// A 2.5-D range image of the cylinder alone: rays on a square grid of view angles with random
/// phase, spaced so that they give the requested number of points (the few excess points are
/// removed evenly). Each point is moved along its ray by normally distributed noise. Scan lines run
/// up and down.
CylinderView SyntheticScan(const CylinderShape& shape, const Viewpoint& view, int points,
                           double noise_m, base::Rng& rng);

/// Keeps `wanted` of its points, evenly spaced in their order; all if there are no more.
void KeepEvenly(int wanted, CylinderView& view);

/// All points that the line scanner measures of a cylinder above the table on which it stands, in
/// the cylinder's frame. The scanner has all its errors except the calibration error, which would
/// turn every fit's axis equally. Its fan and sweep cover the cylinder, its spacing is adapted to
/// give the requested number of points, and the few excess points are removed.
/// @throws base::InputError if the scanner cannot measure that many points.
CylinderView ScanCylinder(const CylinderShape& shape, const Viewpoint& view, int points,
                          sensing::LineScannerOptions scanner, base::Rng& rng);

}  // namespace rangegrasp::cylinders
