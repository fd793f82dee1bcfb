#pragma once

#include <cstdint>
#include <vector>

#include "seam/profile.h"
#include "seam/stitching/mats.h"
#include "seam/stitching/stripe_sensor.h"

namespace rangegrasp::stitching {

/// How a sensor is moved over mats along y, as one moves it to record profiles.
struct RecordOptions {
  int profiles = 520;        ///< >= 1
  double edge_within = 0.6;  ///< share of the line, about its middle, that the edge starts in
  double speed_m_s = 0.03;   ///< > 0
};

/// A sequence of profiles over a seam's mats, with the labelled column of each: where the camera
/// sees the true edge; NaN without an edge.
struct Recording {
  std::vector<seam::RawProfile> raw;
  std::vector<double> label_column;
};

/// Scans along y from y = 0, at the sensor's rate for these mats, from a place that is drawn.
/// Depends on its arguments alone.
Recording Record(const Mats& mats, const StripeSensor& sensor, const RecordOptions& options,
                 std::uint64_t seed);

}  // namespace rangegrasp::stitching
