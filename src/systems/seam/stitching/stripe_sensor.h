#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/rng.h"
#include "seam/calibration.h"
#include "seam/profile.h"
#include "seam/stitching/mats.h"

namespace rangegrasp::seam {

/// A laser-stripe sensor: the laser plane points straight down, a camera views it at an angle and
/// gives the row of each column's brightest pixel. The keys of a sensor file describe the options.
struct StripeSensorOptions {
  std::string name = "base";
  LineGeometry line;
  std::vector<double> lines_ahead_m = {0.080};  ///< fixed line first
  double standoff_m = 0.2;
  double angle_rad = 0.6;
  int rows = 1024;  ///< rows ascend with height
  double range_below_m = 0.045;
  double range_above_m = 0.03;
  double rate_min_hz = 30.0;   ///< dark mats need long exposures ...
  double rate_max_hz = 100.0;  ///< ... bright ones short
  // Disturbances of a row. Frozen settings: docs/seam.md.
  double row_sigma_px = 0.4;
  double row_correlation_columns = 0.0;  ///< neighbors share speckles
  double row_quantum_px = 0.1;
  double speckle = 0.5;
  double lost_return = 0.1;
  double outlier_share = 0.01;
  double outlier_run_columns = 4.0;
  double outlier_sigma_px = 40.0;
  double phantom_share = 0.0;
  double phantom_previous_share = 0.5;
};

/// Reads a file such as models/sensors/stripe_base.yaml.
/// @throws base::InputError naming file, line and key.
StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file);

/// A line's pose in frame M: its middle, and the head's heading (0: line along x).
struct LinePose {
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;  ///< counter-clockwise seen from above
  double height_m = 0.0;     ///< of frame L's origin above the mats' z = 0
};

class StripeSensor {
 public:
  explicit StripeSensor(const StripeSensorOptions& options);
  const StripeSensorOptions& options() const { return options_; }
  /// Measuring rate of the sensor, given by the exposure that these mats need [Hz].
  double Rate(const MatTexture& texture) const;
  /// Scans one line over the mats. `previous` is the line whose brightest pixel a phantom may show
  /// (the three-lines sensor), or null.
  RawProfile Scan(const Mats& mats, const LinePose& pose, double time_s, const RawProfile* previous,
                  base::Rng& rng) const;
  /// Row of a point of the laser plane (x, height) and its column; exact pinhole geometry.
  double RowOf(double height_m) const;
  double ColumnOf(double x_m, double height_m) const;
  /// x of a column at a height: the inverse of ColumnOf.
  double LateralAt(double column, double height_m) const;
  /// Scans of the calibration body at `distances` >= 2 heights over the range.
  std::vector<CalibrationScan> ScanBody(const CalibrationBody& body, int distances,
                                        base::Rng& rng) const;

 private:
  StripeSensorOptions options_;
  double focal_px_, cos_, sin_;
};

/// Motion of a sensor over mats along y to record profiles.
struct RecordOptions {
  int profiles = 520;        ///< >= 1
  double edge_within = 0.6;  ///< share of the line, around its middle, in which the edge starts
  double speed_m_s = 0.03;   ///< > 0
};

struct Recording {
  std::vector<RawProfile> raw;
  std::vector<double> label_column;  ///< where the camera sees the true edge; NaN without an edge
};

/// Scans along y from y = 0 at the sensor's rate for these mats; the edge's place on the line is
/// drawn.
Recording RecordProfiles(const Mats& mats, const StripeSensor& sensor, const RecordOptions& options,
                         std::uint64_t seed);

}  // namespace rangegrasp::seam
