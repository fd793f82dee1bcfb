#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "base/yaml_map.h"
#include "geometry/observation.h"
#include "geometry/plane.h"
#include "stereo/camera.h"
#include "stereo/disparity.h"

namespace rangegrasp::stereo {

/// Where things may stand: an upright cylinder on a table, z of X_WV its axis, z = 0 the table.
struct Volume {
  base::Pose X_WV = base::Pose::Identity();
  double radius_m = 0.0;
  double height_m = 0.0;
};

/// What each does stands with its key (reconstruct.cpp).
struct ReconstructOptions {
  bool remove_blue = true;  ///< section 5.3.2; blue print on an object goes with the table
  /// More than noise does in a grey pixel. Larger: shadows on the table stay; smaller: grey things
  /// are removed.
  double blue_share = 0.15;
  int blue_levels = 12;  ///< in what is nearly black, noise alone makes shares
  int blue_window_px = 5;
  MatchOptions match;
  /// Neighbors share most of their window, so that all of them hold hardly more.
  int step_px = 4;
  /// The mean of those disparities that are near their median. Larger share: fewer samples that mix
  /// two surfaces.
  double min_share = 0.5;
  double max_spread_px = 1.0;
  /// From the left camera along the axis. What stands behind the volume is matched there, where a
  /// search that ended at the volume would find something nearer.
  double near_m = 0.4;
  double far_m = 10.0;
  /// If given, only pixels are matched whose ray meets it, from its own nearest depth on, and only
  /// points in it become samples: a room's walls and floor have little texture, and what is matched
  /// wrongly there hangs in the air.
  std::optional<Volume> volume;
  double volume_height_m = 0.25;    ///< higher than any heap
  double disparity_sigma_px = 0.3;  ///< measured on pictures of the scene (docs/results.md)
  /// In the arm's frame, by the registration. If given, a removed pixel shows the table, and is a
  /// sample on it. Without, it is nothing, and the space over the table is not known to be free.
  std::optional<geometry::Plane> table_W;
  /// Larger: gaps between objects, through which the table is seen, are nothing.
  int min_table_px = 2500;
};

/// Reads the options' keys, to the end of the map. table_W has none: the caller knows it.
/// @throws base::InputError naming file, line, key, value and what would be right.
void ReadReconstructOptions(base::YamlMap& map, ReconstructOptions& options);

/// A pair of pictures as a cloud, and what it was made from.
struct Reconstruction {
  PicturePair rectified;
  Mask kept;            ///< of the left rectified picture: 0 where a pixel was removed
  Disparity disparity;  ///< of the left rectified picture
  /// Organised as the left rectified picture, of which it has every step_px-th row and pixel; the
  /// one origin is the left camera, X_CV the rectified one. noise_m is that of a disparity, along
  /// the ray; 0 for samples of the table.
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
