#include "stereo/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/statistics.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

// Position of the colour type in a PNG's header, and its value for grey without alpha.
constexpr std::size_t kKindByte = 25;
constexpr char kGreyKind = 0;

image::Image Coloured(const image::Grey8& grey) {
  image::Image image;
  cv::Mat room = internal::Room(grey.width, grey.height, image);
  cv::cvtColor(internal::View(grey), room, cv::COLOR_GRAY2RGB);
  return image;
}

/// @param colour  set to false for a grey file
image::Image ReadPicture(const std::filesystem::path& file, bool& colour) {
  const std::string bytes = base::ReadNonEmptyFile(file);
  colour = bytes.size() <= kKindByte || bytes[kKindByte] != kGreyKind;
  try {
    return colour ? image::DecodePng<image::Image>(bytes)
                  : Coloured(image::DecodePng<image::Grey8>(bytes));
  } catch (const base::InputError& error) {
    throw base::InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

// Windows for comparing a pair: as large as those of block matching, one in each cell of a grid of
// this many cells (windows overlap in small pictures), of which those with the most texture are
// used.
constexpr int kWindow_px = 21;
constexpr double kCells = 1200.0;
constexpr std::size_t kMaxWindows = 200;
// Minimum correlation of a window that counts as found (OpenCV's normed correlation).
constexpr double kMinCorrelation = 0.9;
// Minimum slope [grey levels / px, rms] in the direction in which the window changes least: along a
// straight edge a window can be found anywhere. Camera noise of 2 levels gives a slope of 1.4 (half
// the difference of two pixels), and 3 levels over 21 x 21 px locate a window to 2 sqrt(2) / (3 *
// 21) = 0.05 px.
constexpr double kMinSlope = 3.0;

struct Window {
  double texture = 0.0;
  cv::Rect at;
};

bool AllKept(const Mask& kept, const cv::Rect& at) {
  return std::ranges::all_of(
      std::array{at.tl(), at.br() - cv::Point(1, 1), cv::Point(at.br().x - 1, at.y),
                 cv::Point(at.x, at.br().y - 1)},
      [&](const cv::Point& p) { return kept.grey[image::IndexAt(p.x, p.y, kept.width)] != 0; });
}

// The root mean square of the grey values' slope in the direction in which it is least.
double LeastSlope(const cv::Mat& across, const cv::Mat& down, const cv::Rect& at) {
  const double pixels = at.area();
  const double xx = across(at).dot(across(at)) / pixels;
  const double yy = down(at).dot(down(at)) / pixels;
  const double xy = across(at).dot(down(at)) / pixels;
  const double least = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return std::sqrt(std::max(0.0, least));
}

std::vector<Window> TexturedWindows(const cv::Mat& left, const Mask& kept, int first_column,
                                    int within_rows) {
  constexpr double kHalf = 0.5;  // of the difference of both neighbors
  cv::Mat across, down;
  cv::Sobel(left, across, CV_32F, 1, 0, 1, kHalf);
  cv::Sobel(left, down, CV_32F, 0, 1, 1, kHalf);
  const int cell_px = std::max(1, static_cast<int>(std::sqrt(left.cols * left.rows / kCells)));
  std::vector<Window> windows;
  for (int y = within_rows; y + kWindow_px + within_rows <= left.rows; y += cell_px) {
    for (int x = first_column; x + kWindow_px <= left.cols; x += cell_px) {
      const cv::Rect at(x, y, kWindow_px, kWindow_px);
      if (!AllKept(kept, at)) continue;
      const double slope = LeastSlope(across, down, at);
      if (slope >= kMinSlope) windows.push_back({slope, at});
    }
  }
  std::ranges::stable_sort(windows, std::ranges::greater(), &Window::texture);
  if (windows.size() > kMaxWindows) windows.resize(kMaxWindows);
  return windows;
}

// Colour of a share from 0 to 1: from blue over green and yellow to red.
std::array<std::uint8_t, 3> ColourAt(double share) {
  const auto channel = [&](double peak) {
    const double value = std::clamp(1.5 - std::abs(4.0 * share - peak), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(255.0 * value));
  };
  return {channel(3.0), channel(2.0), channel(1.0)};
}

}  // namespace

PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right) {
  PicturePair pair;
  bool right_colour = true;
  pair.left = ReadPicture(left, pair.colour);
  pair.right = ReadPicture(right, right_colour);
  if (pair.colour != right_colour) {
    throw base::InputError(fmt::format("{} is {}, {} is {}: both must have the same format",
                                       left.string(), pair.colour ? "colour" : "grey",
                                       right.string(), right_colour ? "colour" : "grey"));
  }
  if (pair.left.width != pair.right.width || pair.left.height != pair.right.height) {
    throw base::InputError(fmt::format(
        "{} has {} x {} pixels, {} has {} x {}: both must have the same size", left.string(),
        pair.left.width, pair.left.height, right.string(), pair.right.width, pair.right.height));
  }
  return pair;
}

RowOffset MeasureRowOffset(const PicturePair& pair, const Mask& kept, double min_px, double max_px,
                           int within_rows) {
  const internal::SingleThread single;
  const cv::Mat left = internal::GreyOf(pair.left), right = internal::GreyOf(pair.right);
  const int low = cvFloor(min_px), high = cvCeil(max_px);
  RowOffset result;
  std::vector<double> offsets;
  for (const Window& window : TexturedWindows(left, kept, high, within_rows)) {
    ++result.textured;
    const cv::Rect strip(window.at.x - high, window.at.y - within_rows, kWindow_px + high - low,
                         kWindow_px + 2 * within_rows);
    cv::Mat agreement;
    cv::matchTemplate(right(strip), left(window.at), agreement, cv::TM_CCOEFF_NORMED);
    double best = 0.0;
    cv::Point place;
    cv::minMaxLoc(agreement, nullptr, &best, nullptr, &place);
    if (best < kMinCorrelation) continue;
    offsets.push_back(place.y - within_rows);
    result.in_row += std::abs(offsets.back()) <= kRowTolerance_px ? 1 : 0;
  }
  result.found = static_cast<int>(offsets.size());
  if (!offsets.empty()) result.median_px = base::MedianOf(offsets);
  return result;
}

image::Image DisparityPicture(const Disparity& disparity) {
  constexpr double kOutermost = 0.01;
  std::vector<float> there;
  for (const float d : disparity.grey) {
    if (!std::isnan(d)) there.push_back(d);
  }
  const double low = there.empty() ? 0.0 : base::QuantileOf(there, kOutermost);
  const double high = there.empty() ? 1.0 : base::QuantileOf(there, 1.0 - kOutermost);
  image::Image picture{disparity.width, disparity.height, {}};
  picture.rgb.reserve(3 * disparity.grey.size());
  for (const float d : disparity.grey) {
    std::array<std::uint8_t, 3> colour{0, 0, 0};
    if (!std::isnan(d)) {
      colour = ColourAt(std::clamp((d - low) / std::max(high - low, 1e-9), 0.0, 1.0));
    }
    picture.rgb.insert(picture.rgb.end(), colour.begin(), colour.end());
  }
  return picture;
}

}  // namespace rangegrasp::stereo
