#pragma once

#include <vector>

#include "base/rng.h"
#include "seam/calibration_body.h"
#include "seam/profile.h"
#include "seam/stitching/mats.h"
#include "seam/stitching/stripe_sensor_options.h"

namespace rangegrasp::stitching {

/// A line's pose in frame M: its middle, and the head's heading (0: line along x).
struct LinePose {
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;  ///< counter-clockwise seen from above
  double height_m = 0.0;     ///< of frame L's origin above the mats' z = 0
};

class StripeSensor {
 public:
  /// @throws std::invalid_argument if an option is out of range.
  explicit StripeSensor(const StripeSensorOptions& options);
  const StripeSensorOptions& options() const { return options_; }
  /// The exposure these mats need decides how often the sensor can measure [Hz].
  double Rate(const MatTexture& texture) const;
  /// One line over the mats. `previous` is the line the brightest pixel of which a phantom may show
  /// (the three-lines sensor), or null.
  seam::RawProfile Scan(const Mats& mats, const LinePose& pose, double time_s,
                        const seam::RawProfile* previous, base::Rng& rng) const;
  /// Row of a point of the laser plane (x, height) and its column; exact pinhole geometry.
  double RowOf(double height_m) const;
  double ColumnOf(double x_m, double height_m) const;
  /// x of a column at a height: the inverse of ColumnOf.
  double LateralAt(double column, double height_m) const;
  /// Scans of the calibration body at `distances` >= 2 heights over the range.
  std::vector<seam::CalibrationScan> ScanBody(const seam::CalibrationBody& body, int distances,
                                              base::Rng& rng) const;
  /// The calibration from such scans of the usual body.
  seam::Calibration Calibrate(int distances, base::Rng& rng) const;

 private:
  seam::CalibrationScan ScanBodyAt(const seam::CalibrationBody& body, double base_m,
                                   base::Rng& rng) const;

  StripeSensorOptions options_;
  double focal_px_, cos_, sin_;
};

}  // namespace rangegrasp::stitching
