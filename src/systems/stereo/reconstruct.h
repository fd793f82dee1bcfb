#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/image/image.h"
#include "geometry/observation.h"
#include "stereo/match.h"
#include "stereo/reconstruct_options.h"
#include "stereo/rectify.h"

namespace rangegrasp::stereo {

/// A pair of pictures as a cloud, and what it was made from.
struct Reconstruction {
  RectifiedPair rectified;
  Mask kept;            ///< of the left rectified picture: 0 where a pixel was removed
  Disparity disparity;  ///< of the left rectified picture
  /// Organised as the left rectified picture with one row a profile and every step_px-th pixel;
  /// the one origin is the left camera, X_CV the rectified one. noise_m is a disparity's deviation
  /// as a depth, along the ray; 0 for samples of the table.
  geometry::View view;
  /// Of each sample: the pixel of the left picture, as it was taken, that its middle comes from.
  std::vector<Eigen::Vector2f> left_pixel;
};

/// Section 5.3.2 from two pictures to a cloud: rectification, removal of blue pixels, disparities,
/// triangulation. Depends on the arguments alone; single-threaded. O(pixels * disparities).
/// @throws base::InputError if the pictures' size is not the calibrated camera's.
/// @throws std::invalid_argument if an option is out of range.
Reconstruction Reconstruct(const image::Image& left, const image::Image& right,
                           const Rectifier& rectifier, const ReconstructOptions& options);

/// Which pixels of a picture are kept: those in which blue is not dominant, and which are not
/// black.
Mask WithoutBlue(const image::Image& picture, double blue_share, int blue_levels, int window_px);

}  // namespace rangegrasp::stereo
