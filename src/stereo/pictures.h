#pragma once

#include <filesystem>
#include <optional>

#include "image/image.h"
#include "stereo/match.h"
#include "stereo/rectify.h"

namespace rangegrasp::stereo {

/// Two pictures of one scene, as files hold them.
struct PicturePair {
  image::Image left;
  image::Image right;
  /// False: both files are grey, and each channel holds their brightness; no pixel is blue.
  bool colour = true;
};

/// Reads two PNG files, both of 8-bit colour or both of 8-bit grey.
/// @throws core::InputError naming the file, or both where one is grey and the other is not, or
/// where they differ in size.
PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right);

/// How far a pair is from what rectification promises: corresponding pixels in one row.
struct RowOffset {
  double median_px = 0.0;  ///< right row minus left row
  int windows = 0;         ///< that were found again
};
/// Looks for windows with much texture in the right picture, in rows within max_rows_px, too. Tells
/// pictures of another camera of the same size, or of one that was moved, from those that the
/// calibration belongs to. O(windows * disparities * max_rows_px).
RowOffset MeasureRowOffset(const RectifiedPair& pair, const Mask& kept, double min_px,
                           double max_px, int max_rows_px = 8);

/// Disparities as 16-bit grey: 256 levels a pixel (as in the KITTI benchmark), 0 where there is
/// none.
image::Grey16 EncodeDisparity(const Disparity& disparity);

/// Disparities in colours from far (blue) to near (red); black where there is none.
/// The colours span the disparities that are there but for the outermost percent at both ends.
image::Image DisparityPicture(const Disparity& disparity);

/// Both rectified pictures beside each other, with a line every spacing_px rows: what stands on a
/// line on the left stands on it on the right.
image::Image RectifiedPicture(const RectifiedPair& pair, int spacing_px = 60);

}  // namespace rangegrasp::stereo
