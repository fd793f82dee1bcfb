#pragma once

#include <cstdint>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/fit.h"
#include "geometry/point_cloud.h"
#include "sensing/line_scanner_options.h"

namespace rangegrasp::cylinders {

/// A cylinder that stands along x, its middle in the origin, as in table 4.3: v = (1, 0, 0). The
/// end at +x is the upper one.
struct CylinderShape {
  double radius_m = 0.010;
  double height_m = 0.100;
};

/// Where it is seen from: the eye lies in the plane of x and z, on the side of +z, and looks down
/// at the middle.
struct Viewpoint {
  double distance_m = 0.9;             ///< the scanner's focus distance
  double pitch_rad = base::Deg(37.0);  ///< the dissertation's, below the horizontal

  Eigen::Vector3d Eye() const;
};

/// What a sensor saw of one cylinder, in the cylinder's frame.
struct CylinderView {
  geometry::Points points;           ///< [m], in the order of the scan
  std::vector<std::uint32_t> lines;  ///< each point's scan line
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();

  FitInput Input() const { return {points, eye, Eigen::Vector3d::UnitX()}; }
};

/// A 2.5-D range image of the cylinder alone: rays in a square grid of view angles, at a random
/// phase, as far apart as gives the points that are asked for (a few too many are left out evenly),
/// each point moved along its ray by normal noise. Scan lines run up and down.
/// @throws base::InputError for fewer than three points.
CylinderView SyntheticScan(const CylinderShape& shape, const Viewpoint& view, int points,
                           double noise_m, base::Rng& rng);

/// So many of its points, evenly in their order. All where there are no more.
void KeepEvenly(int wanted, CylinderView& view);

struct ScannedOptions {
  sensing::LineScannerOptions scanner;
  /// What is not higher above the table is not taken for the cylinder's: the preselection's.
  double table_clearance_m = 0.002;
  double table_m = 0.6;  ///< side of the (square) table that it stands on
};

/// A scan of the cylinder, standing on a table, by the line scanner with all of its errors but the
/// calibration's, which turns every fit's axis alike; in the cylinder's frame: all that was
/// measured above the table. The scanner's lines are put closer or wider, its fan and its sweep
/// round the cylinder, until there are the points that are asked for; a few too many are left out.
/// @throws base::InputError if the scanner cannot see so many.
CylinderView ScanCylinder(const CylinderShape& shape, const Viewpoint& view, int points,
                          const ScannedOptions& options, base::Rng& rng);

}  // namespace rangegrasp::cylinders
