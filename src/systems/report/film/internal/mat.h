#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "base/image/image.h"

namespace rangegrasp::draw::internal {

/// The same pixels: the picture must outlive it.
inline cv::Mat MatOf(image::Image& picture) {
  return {picture.height, picture.width, CV_8UC3, picture.rgb.data()};
}
/// For reading.
inline cv::Mat MatOf(const image::Image& picture) {
  return {picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.rgb.data())};
}

/// Red, green, blue: the order of a picture's bytes, whatever OpenCV calls them.
using Rgb = cv::Scalar;

/// Letters with their feet's left end at (x, y) [px].
void Write(const std::string& text, int x, int y, double scale, image::Image& into,
           const Rgb& color = {30, 30, 30});

}  // namespace rangegrasp::draw::internal
