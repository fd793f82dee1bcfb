#pragma once

#include <cstdint>
#include <vector>

namespace rangegrasp::sensing {

/// Why a sample of the range image is what it is. A sample is a laser ray, so that what lies in the
/// laser's shadow has no sample at all (the image jumps there): see ClassifySurface.
enum class SampleState : std::uint8_t {
  kMeasured,
  kCameraShadow,  ///< lit by the laser, within the camera's view, but hidden from the camera
  kDropout,       ///< seen, but lost to grazing incidence, low albedo, gloss or clarity
  kOutOfView      ///< the ray meets nothing, or its spot lies outside the sensor's window
};

/// What only the scorer may read; the same layout as the image. Of a measured sample: the surface
/// that gave most of its light; of any other: the first surface that the ray meets.
struct ScanTruth {
  std::vector<SampleState> state;
  std::vector<std::uint32_t> label;  ///< 0 where nothing was met
  std::vector<double> true_range_m;  ///< from the laser to that surface; NaN where nothing
};

}  // namespace rangegrasp::sensing
