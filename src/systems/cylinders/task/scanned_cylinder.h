#pragma once

#include "cylinders/task/synthetic_cylinder.h"
#include "sensing/line_scanner_options.h"

namespace rangegrasp::cylinder_task {

struct ScannedOptions {
  sensing::LineScannerOptions scanner;
  /// What is not higher above the table is not taken for the cylinder's: the preselection's.
  double table_clearance_m = 0.002;
  double table_m = 0.6;  ///< side of the (square) table that it stands on
};

/// A scan of the cylinder by the line scanner, standing on a table, in the cylinder's frame: all
/// that was measured above the table. The scanner's lines are put closer or wider, its fan and its
/// sweep round the cylinder, until there are the points that are asked for; those that are too many
/// are left out evenly. Shadows, drop-outs, mixed points at the outline, speckle, jitter of the pan
/// unit and quantisation are the scanner's. Its calibration is taken to be exact: what is off there
/// turns every fit's axis alike.
/// @throws base::InputError if the scanner cannot see so many.
CylinderView ScanCylinder(const CylinderShape& shape, const Viewpoint& view, int points,
                          const ScannedOptions& options, base::Rng& rng);

}  // namespace rangegrasp::cylinder_task
