#pragma once

#include <cstddef>

#include "core/frames.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// An organised range image: `profiles` rows (one a laser line) of `samples` columns (along the
/// line).
struct RangeImage {
  int profiles = 0;
  int samples = 0;
  Points points_C;   ///< row-major, [m]; NaN where nothing was measured
  Points origins_C;  ///< the sensor's origin for each profile [m]; one entry where it does not move

  std::size_t Index(int profile, int sample) const {
    return static_cast<std::size_t>(profile) * static_cast<std::size_t>(samples) +
           static_cast<std::size_t>(sample);
  }
};

/// The measured points of an image, in its order; where `source` is given it receives their
/// positions in the image.
PointCloud ToCloud(const RangeImage& image, Indices* source = nullptr);

}  // namespace rangegrasp::geometry
