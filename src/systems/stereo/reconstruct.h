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

/// The space of objects: an upright cylinder on a table. Its axis is z of X_WV; the table is z = 0.
struct Volume {
  base::Pose X_WV = base::Pose::Identity();
  double radius_m = 0.0;
  double height_m = 0.0;
};

/// The keys in reconstruct.cpp describe each option.
struct ReconstructOptions {
  bool remove_blue = true;  ///< section 5.3.2; also removes blue print on objects
  MatchOptions match;
  /// Neighbors share most of their window, so using all pixels would add hardly any information.
  int step_px = 4;
  /// Along the left camera's axis. Objects behind the volume are matched at their own depth; a
  /// search that ended at the volume would find a wrong, nearer match.
  double near_m = 0.4;
  double far_m = 10.0;
  /// If given, only pixels whose ray meets it are matched, from the ray's nearest depth in it on,
  /// and only points in it become samples. A room's walls and floor have little texture, and wrong
  /// matches there would be points in the air.
  std::optional<Volume> volume;
  double volume_height_m = 0.25;    ///< higher than any heap
  double disparity_sigma_px = 0.3;  ///< measured on pictures of the scene (docs/results.md)
  /// In the arm's frame, by the registration. If given, a removed pixel is a sample on the table.
  /// If not, it gives no sample, and the space over the table is not known to be free.
  std::optional<geometry::Plane> table_W;
  /// Larger: gaps between objects through which the table is seen give no samples.
  int min_table_px = 2500;
};

/// Reads the options' keys, to the end of the map. table_W has no key: the caller sets it.
/// @throws base::InputError naming file, line, key, value and what is valid.
void ReadReconstructOptions(base::YamlMap& map, ReconstructOptions& options);

/// A cloud from a pair of pictures, and the data from which it was made.
struct Reconstruction {
  PicturePair rectified;
  Mask kept;            ///< of the left rectified picture: 0 where a pixel was removed
  Disparity disparity;  ///< of the left rectified picture
  /// Organised like the left rectified picture, with every step_px-th row and pixel. The only
  /// origin is the left camera; X_CV is that of the rectified one. noise_m is the disparity's noise
  /// along the ray; 0 for samples of the table.
  geometry::View view;
  /// For each sample: the pixel of the original left picture that corresponds to its middle.
  std::vector<Eigen::Vector2f> left_pixel;
};

/// Section 5.3.2 from two pictures to a cloud: rectification, removal of blue pixels, disparities,
/// triangulation. Depends only on the arguments; single-threaded. O(pixels * disparities).
/// @throws base::InputError if the pictures' size is not the calibrated camera's.
Reconstruction Reconstruct(const image::Image& left, const image::Image& right,
                           const Rectifier& rectifier, const ReconstructOptions& options);

/// Mask of the kept pixels of a picture: those that are not black and in which blue is not
/// dominant.
Mask WithoutBlue(const image::Image& picture, double blue_share, int blue_levels, int window_px);

}  // namespace rangegrasp::stereo
