#include "stereo/match.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

// OpenCV's: the number of disparities is a multiple of 16; results are sixteenths of a pixel.
constexpr int kDisparityStep = 16;
constexpr float kSubpixels = 16.0F;
// Slopes are cut off here by both matchers' prefilters (OpenCV's default of block matching): a
// difference of exposure does not count, nor does one strong edge in a window.
constexpr int kPrefilterCap = 31;

void CheckOptions(const MatchOptions& o, double min_px, double max_px) {
  const auto odd = [](int window, int low) { return window >= low && window % 2 == 1; };
  if (!odd(o.block_window_px, 5)) {
    throw std::invalid_argument(
        fmt::format("block_window_px {}: odd and at least 5", o.block_window_px));
  }
  if (!odd(o.semi_global_window_px, 1)) {
    throw std::invalid_argument(
        fmt::format("semi_global_window_px {}: odd and at least 1", o.semi_global_window_px));
  }
  if (!(min_px >= 0.0 && max_px > min_px)) {
    throw std::invalid_argument(
        fmt::format("disparities from {:.1f} to {:.1f} px: ascending from 0", min_px, max_px));
  }
}

cv::Mat View(const image::Grey8& picture) {
  return cv::Mat(
      picture.height, picture.width, CV_8UC1,
      const_cast<std::uint8_t*>(picture.grey.data()));  // NOLINT: OpenCV has no const view
}

// The rectangle round what is kept; empty if nothing is.
cv::Rect KeptRectangle(const Mask& mask) {
  int left = mask.width, right = -1, top = mask.height, bottom = -1;
  for (int y = 0; y < mask.height; ++y) {
    const auto* row = mask.grey.data() + static_cast<std::ptrdiff_t>(y) * mask.width;
    for (int x = 0; x < mask.width; ++x) {
      if (row[x] == 0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
}

// Room for windows at the border, and to the left for the right picture's columns.
cv::Rect Widened(const cv::Rect& kept, int margin, int max_px, const Mask& mask) {
  const cv::Rect wide(kept.x - max_px - margin, kept.y - margin, kept.width + max_px + 2 * margin,
                      kept.height + 2 * margin);
  return wide & cv::Rect(0, 0, mask.width, mask.height);
}

cv::Mat SixteenthsOf(const cv::Mat& left, const cv::Mat& right, int min_px, int disparities,
                     const MatchOptions& o) {
  cv::Mat sixteenths;
  if (o.method == MatchMethod::kBlock) {
    const auto matcher = cv::StereoBM::create(disparities, o.block_window_px);
    matcher->setMinDisparity(min_px);
    matcher->setPreFilterCap(kPrefilterCap);
    matcher->setTextureThreshold(o.min_texture);
    matcher->setUniquenessRatio(o.uniqueness_percent);
    matcher->setDisp12MaxDiff(o.max_left_right_px);
    matcher->setSpeckleWindowSize(o.min_patch_px);
    matcher->setSpeckleRange(o.patch_step_px);
    matcher->compute(left, right, sixteenths);
    return sixteenths;
  }
  const int window = o.semi_global_window_px;
  const double area = static_cast<double>(window) * window;
  const auto matcher = cv::StereoSGBM::create(
      min_px, disparities, window, static_cast<int>(std::lround(o.small_step_cost * area)),
      static_cast<int>(std::lround(o.large_step_cost * area)), o.max_left_right_px, kPrefilterCap,
      o.uniqueness_percent, o.min_patch_px, o.patch_step_px, cv::StereoSGBM::MODE_SGBM_3WAY);
  matcher->compute(left, right, sixteenths);
  return sixteenths;
}

}  // namespace

Disparity Match(const image::Grey8& left, const image::Grey8& right, const Mask& left_mask,
                double min_px, double max_px, const MatchOptions& options) {
  CheckOptions(options, min_px, max_px);
  if (left.width != right.width || left.height != right.height || left.width != left_mask.width ||
      left.height != left_mask.height) {
    throw std::invalid_argument("pictures and mask must be of one size");
  }
  Disparity result{left.width, left.height, {}};
  result.grey.assign(left.grey.size(), std::numeric_limits<float>::quiet_NaN());
  const cv::Rect kept = KeptRectangle(left_mask);
  if (kept.empty()) return result;

  const int first = static_cast<int>(std::floor(min_px));
  const int range = static_cast<int>(std::ceil(max_px)) - first + 1;
  const int disparities = (range + kDisparityStep - 1) / kDisparityStep * kDisparityStep;
  const int margin = std::max(options.block_window_px, options.semi_global_window_px);
  const cv::Rect part = Widened(kept, margin, first + disparities, left_mask);
  if (part.width <= first + disparities + margin || part.height <= margin) return result;

  const internal::SingleThread single;
  const cv::Mat sixteenths =
      SixteenthsOf(View(left)(part), View(right)(part), first, disparities, options);
  const int none = (first - 1) * static_cast<int>(kSubpixels);
  for (int y = 0; y < part.height; ++y) {
    const auto* row = sixteenths.ptr<std::int16_t>(y);
    for (int x = 0; x < part.width; ++x) {
      const auto at = static_cast<std::size_t>(part.y + y) * static_cast<std::size_t>(left.width) +
                      static_cast<std::size_t>(part.x + x);
      if (left_mask.grey[at] == 0 || row[x] <= none) continue;
      result.grey[at] = static_cast<float>(row[x]) / kSubpixels;
    }
  }
  return result;
}

}  // namespace rangegrasp::stereo
