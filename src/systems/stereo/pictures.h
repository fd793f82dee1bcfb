#pragma once

#include <filesystem>

#include "stereo/camera.h"
#include "stereo/disparity.h"

namespace rangegrasp::stereo {

/// Reads two PNG files, both of 8-bit colour or both of 8-bit grey.
/// @throws base::InputError naming the file, or both files if only one is grey or their sizes
/// differ.
PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right);

/// Deviation of a pair from ideal rectification, where corresponding pixels are in the same row.
struct RowOffset {
  int textured = 0;        ///< number of windows searched for
  int found = 0;           ///< number of windows found
  int in_row = 0;          ///< number of these within kRowTolerance_px of their row
  double median_px = 0.0;  ///< right row minus left row, of those found
};
/// Rectification with a calibration that fits leaves a fraction of a pixel, and half a window hides
/// it.
inline constexpr double kRowTolerance_px = 2.0;
/// Searches for textured windows of the left picture in the right one, also in a number of rows
/// above and below: in pictures of another camera, or one that was moved, they are not in the same
/// row. O(windows * disparities * rows).
RowOffset MeasureRowOffset(const PicturePair& pair, const Mask& kept, double min_px, double max_px,
                           int within_rows);

/// Disparities in colours from far (blue) to near (red); black where there is none. The colours
/// span the disparities except for the outermost percent at both ends.
image::Image DisparityPicture(const Disparity& disparity);

}  // namespace rangegrasp::stereo
