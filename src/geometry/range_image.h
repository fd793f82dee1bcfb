#pragma once

#include <cstddef>

#include "base/frames.h"
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
  /// Where the sensor was when it measured the sample at `index`.
  /// @throws std::invalid_argument unless there is one origin, or one a profile.
  const Eigen::Vector3d& OriginOf(std::size_t index) const;
};

/// The measured points of an image, in its order; where `source` is given it receives their
/// positions in the image.
PointCloud ToCloud(const RangeImage& image, Indices* source = nullptr);

/// The distance of neighbors in the image [m]: the median over the samples of the mean distance to
/// the next sample of the profile and to the same sample of the next profile (to one of them, where
/// the other was not measured). A mean, because the median of both kinds of distances together
/// would jump from one to the other where profiles are further apart than samples. 0 if no two
/// neighbors were measured. O(n).
double MedianSpacing(const RangeImage& image);

}  // namespace rangegrasp::geometry
