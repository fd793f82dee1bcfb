#pragma once

#include <compare>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/frames.h"
#include "geometry/color.h"
#include "geometry/range_image.h"

namespace rangegrasp::geometry {

/// What one sensor measured from one place. Nothing in it is truth.
struct View {
  /// Organised samples in the order of the scan, in the observation's frame C (in a trial W), by
  /// the calibration that the robot knows.
  RangeImage image;
  base::Pose X_CV = base::Pose::Identity();  ///< the sensor's frame, as calibrated
  /// Standard deviation of the measured point along its ray [m], one a sample (NaN where nothing
  /// was measured), by the sensor's own model; empty where it is not known.
  std::vector<float> noise_m;
  /// The color that each sample was seen in, where the sensor has a camera for colors; else empty.
  /// Of no meaning where nothing was measured.
  std::vector<Rgb> colors;
  double spacing_m = 0.0;  ///< median distance of neighbors in the image [m]; 0: not known
};

/// A sample of an observation: its view, and its position in that view's image.
struct SampleId {
  std::uint32_t view = 0;
  std::uint32_t sample = 0;

  auto operator<=>(const SampleId&) const = default;  ///< by view, then by sample
};

/// One or more views of one scene, in one frame C.
struct Observation {
  std::vector<View> views;
};

/// One view of which nothing but the image is known.
inline Observation ObservationOf(RangeImage image) {
  Observation observation;
  observation.views.emplace_back().image = std::move(image);
  return observation;
}

}  // namespace rangegrasp::geometry
