#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/observation.h"
#include "geometry/plane.h"
#include "image/image.h"
#include "stereo/match.h"
#include "stereo/rectify.h"

namespace rangegrasp::stereo {

struct ReconstructOptions {
  /// Removes the pixels whose dominant colour component is blue before anything is matched: the
  /// table's (section 5.3.2). Blue print on an object goes with them.
  bool remove_blue = true;
  /// Blue is dominant if it exceeds red and green by this share of itself: more than noise does in
  /// a grey pixel. Larger: shadows on the table stay; smaller: grey things are removed.
  double blue_share = 0.15;
  /// Pixels that differ from most of their neighborhood of this side are noise of the colours; odd.
  int blue_window_px = 5;
  MatchOptions match;
  /// One sample for so many pixels in both directions: the mean of those disparities that are near
  /// their median. Neighbors share most of their window, so that all of them tell hardly more.
  int step_px = 4;
  /// A sample needs this share of its pixels, no further from their median than this [px]. Larger:
  /// samples that mix two surfaces.
  double min_share = 0.5;
  double max_spread_px = 1.0;
  /// The range of depths that is searched [m], from the left camera along the axis.
  double near_m = 0.4;
  double far_m = 1.6;
  /// Standard deviation of a disparity [px], measured on pictures of the scene (docs/stereo.md).
  double disparity_sigma_px = 0.2;
  /// Where the table is, in the arm's frame, by the registration. If given, removed pixels are
  /// samples on it: a blue pixel shows the table, whose place is known. Without, they are nothing,
  /// and nothing tells that the space over the table is free.
  std::optional<geometry::Plane> table_W;
};

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
/// @throws core::InputError if the pictures' size is not the calibrated camera's.
/// @throws std::invalid_argument if an option is out of range.
Reconstruction Reconstruct(const image::Image& left, const image::Image& right,
                           const Rectifier& rectifier, const ReconstructOptions& options);

/// Which pixels of a picture are kept: those in which blue is not dominant, and which are not
/// black.
Mask WithoutBlue(const image::Image& picture, double blue_share, int window_px);

}  // namespace rangegrasp::stereo
