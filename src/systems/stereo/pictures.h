#pragma once

#include <filesystem>

#include "base/image/image.h"
#include "stereo/camera.h"
#include "stereo/disparity.h"
#include "stereo/reconstruct.h"

namespace rangegrasp::stereo {

/// Reads two PNG files, both of 8-bit colour or both of 8-bit grey.
/// @throws base::InputError naming the file, or both where one is grey and the other is not, or
/// where they differ in size.
PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right);

/// How far a pair is from what rectification promises: corresponding pixels in one row.
struct RowOffset {
  int textured = 0;        ///< windows that were looked for
  int found = 0;           ///< and found again
  int in_row = 0;          ///< of these: within kRowTolerance_px of their row
  double median_px = 0.0;  ///< right row minus left row, of those found
};
/// Rectification with a calibration that fits leaves a fraction of a pixel, and half a window hides
/// it.
inline constexpr double kRowTolerance_px = 2.0;
/// Looks for windows of the left picture with texture in the right one, in so many rows above and
/// below, too: pictures of another camera, or of one that was moved, do not stand in rows.
/// O(windows * disparities * rows).
RowOffset MeasureRowOffset(const PicturePair& pair, const Mask& kept, double min_px, double max_px,
                           int within_rows);

/// Writes what a reconstruction was made from: rectified.png (both pictures with lines along the
/// rows), disparity.png (in colours) and disparity16.png (256 levels a pixel, 0 for none).
void WriteStereoPictures(const Reconstruction& made, const std::filesystem::path& folder);

}  // namespace rangegrasp::stereo
