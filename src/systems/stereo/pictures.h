#pragma once

#include <filesystem>

#include "base/image/image.h"
#include "stereo/camera.h"
#include "stereo/disparity.h"
#include "stereo/reconstruct.h"

namespace rangegrasp::stereo {

/// Two pictures of one scene, as files hold them.
struct PicturePair {
  image::Image left;
  image::Image right;
  /// False: both files are grey, and each channel holds their brightness; no pixel is blue.
  bool colour = true;
};

/// Reads two PNG files, both of 8-bit colour or both of 8-bit grey.
/// @throws base::InputError naming the file, or both where one is grey and the other is not, or
/// where they differ in size.
PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right);

/// How far a pair is from what rectification promises: corresponding pixels in one row.
struct RowOffset {
  int textured = 0;        ///< windows that were looked for
  int found = 0;           ///< and found again
  int in_row = 0;          ///< of these: within RowSearch::tolerance_px of their row
  double median_px = 0.0;  ///< right row minus left row, of those found
};
struct RowSearch {
  /// That are searched above and below each window's row. [px]
  int rows = 8;
  /// Rectification with a calibration that fits leaves a fraction of a pixel, and half a window
  /// hides it. [px]
  double tolerance_px = 2.0;
  /// Grey levels a pixel, root mean square, in the direction in which the window changes least:
  /// along a straight edge a window can be found anywhere. A camera's noise of 2 levels makes a
  /// slope of 1.4 (half the difference of two pixels), and 3 levels over 21 x 21 px place a window
  /// to 2 sqrt(2) / (3 * 21) = 0.05 px.
  double min_slope = 3.0;
};
/// Looks for windows of the left picture with texture in the right one, in rows near by, too. Tells
/// pictures of another camera of the same size, or of one that was moved, from those that the
/// calibration belongs to. O(windows * disparities * rows).
RowOffset MeasureRowOffset(const RectifiedPair& pair, const Mask& kept, double min_px,
                           double max_px, const RowSearch& search = {});

/// Writes what a reconstruction was made from: rectified.png (both pictures with lines along the
/// rows), disparity.png (in colours) and disparity16.png (256 levels a pixel, 0 for none).
void WriteStereoPictures(const Reconstruction& made, const std::filesystem::path& folder);

}  // namespace rangegrasp::stereo
