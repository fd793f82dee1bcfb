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

// Where a PNG's header states its kind of pixels, and what it states of grey without alpha.
constexpr std::size_t kKindByte = 25;
constexpr char kGreyKind = 0;

constexpr double kLevelsPerPixel = 256.0;

struct Picture {
  image::Image image;
  bool colour = true;
};

image::Image Coloured(const image::Grey8& grey) {
  image::Image image{grey.width, grey.height, {}};
  image.rgb.reserve(3 * grey.grey.size());
  for (const std::uint8_t level : grey.grey) image.rgb.insert(image.rgb.end(), 3, level);
  return image;
}

Picture ReadPicture(const std::filesystem::path& file) {
  const std::string bytes = base::ReadNonEmptyFile(file);
  try {
    if (bytes.size() > kKindByte && bytes[kKindByte] == kGreyKind) {
      return {Coloured(image::DecodePng<image::Grey8>(bytes)), false};
    }
    return {image::DecodePng<image::Image>(bytes), true};
  } catch (const base::InputError& error) {
    throw base::InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

// The windows that a pair is compared by: as large as those of block matching, one in each cell of
// a grid of so many cells (windows overlap in small pictures), of these the ones with the most
// texture.
constexpr int kWindow_px = 21;
constexpr double kCells = 1200.0;
constexpr std::size_t kMaxWindows = 200;
// A window that agrees less was not found again (OpenCV's normed correlation).
constexpr double kMinCorrelation = 0.9;

struct Window {
  double texture = 0.0;
  cv::Rect at;
};

bool AllKept(const Mask& kept, const cv::Rect& at) {
  const int right = at.br().x - 1, low = at.br().y - 1;
  for (const cv::Point& corner :
       {at.tl(), cv::Point(right, low), cv::Point(at.x, low), cv::Point(right, at.y)}) {
    if (kept.grey[internal::IndexAt(corner.x, corner.y, kept.width)] == 0) return false;
  }
  return true;
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
                                    const RowSearch& search) {
  constexpr double kHalf = 0.5;  // of the difference of both neighbors
  cv::Mat across, down;
  cv::Sobel(left, across, CV_32F, 1, 0, 1, kHalf);
  cv::Sobel(left, down, CV_32F, 0, 1, 1, kHalf);
  const int cell_px = std::max(1, static_cast<int>(std::sqrt(left.cols * left.rows / kCells)));
  std::vector<Window> windows;
  for (int y = search.rows; y + kWindow_px + search.rows <= left.rows; y += cell_px) {
    for (int x = first_column; x + kWindow_px <= left.cols; x += cell_px) {
      const cv::Rect at(x, y, kWindow_px, kWindow_px);
      if (!AllKept(kept, at)) continue;
      const double slope = LeastSlope(across, down, at);
      if (slope >= search.min_slope) windows.push_back({slope, at});
    }
  }
  std::stable_sort(windows.begin(), windows.end(),
                   [](const Window& a, const Window& b) { return a.texture > b.texture; });
  if (windows.size() > kMaxWindows) windows.resize(kMaxWindows);
  return windows;
}

// From blue over green and yellow to red, at 0 to 1.
std::array<std::uint8_t, 3> ColourAt(double share) {
  const auto channel = [&](double peak) {
    const double value = std::clamp(1.5 - std::abs(4.0 * share - peak), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(255.0 * value));
  };
  return {channel(3.0), channel(2.0), channel(1.0)};
}

/// Disparities as 16-bit grey: 256 levels a pixel (as in the KITTI benchmark), 0 where there is
/// none.
image::Grey16 EncodeDisparity(const Disparity& disparity) {
  image::Grey16 picture{disparity.width, disparity.height, {}};
  picture.grey.reserve(disparity.grey.size());
  for (const float d : disparity.grey) {
    const double level = std::isnan(d) ? 0.0 : std::clamp(d * kLevelsPerPixel, 1.0, 65535.0);
    picture.grey.push_back(static_cast<std::uint16_t>(std::lround(level)));
  }
  return picture;
}

/// Disparities in colours from far (blue) to near (red); black where there is none. The colours
/// span the disparities that are there but for the outermost percent at both ends.
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

/// Both rectified pictures side by side, with a line every so many rows: what stands on a line
/// on the left stands on it on the right.
image::Image RectifiedPicture(const RectifiedPair& pair) {
  constexpr int kSpacing_px = 60;
  constexpr std::array<std::uint8_t, 3> kLine = {255, 60, 40};
  image::Image both{2 * pair.left.width, pair.left.height, {}};
  both.rgb.reserve(2 * pair.left.rgb.size());
  for (int y = 0; y < both.height; ++y) {
    const bool line = y % kSpacing_px == kSpacing_px / 2;
    for (const image::Image* picture : {&pair.left, &pair.right}) {
      for (int x = 0; x < picture->width; ++x) {
        const std::uint8_t* pixel = line ? kLine.data() : picture->At(x, y);
        both.rgb.insert(both.rgb.end(), pixel, pixel + 3);
      }
    }
  }
  return both;
}

}  // namespace

PicturePair ReadPicturePair(const std::filesystem::path& left, const std::filesystem::path& right) {
  Picture a = ReadPicture(left), b = ReadPicture(right);
  if (a.colour != b.colour) {
    throw base::InputError(fmt::format("{} is {}, {} is {}: both must be of one kind",
                                       left.string(), a.colour ? "colour" : "grey", right.string(),
                                       b.colour ? "colour" : "grey"));
  }
  if (a.image.width != b.image.width || a.image.height != b.image.height) {
    throw base::InputError(fmt::format(
        "{} has {} x {} pixels, {} has {} x {}: both must be of one size", left.string(),
        a.image.width, a.image.height, right.string(), b.image.width, b.image.height));
  }
  return {std::move(a.image), std::move(b.image), a.colour};
}

RowOffset MeasureRowOffset(const RectifiedPair& pair, const Mask& kept, double min_px,
                           double max_px, const RowSearch& search) {
  const internal::SingleThread single;
  cv::Mat left, right;
  cv::cvtColor(internal::View(pair.left), left, cv::COLOR_RGB2GRAY);
  cv::cvtColor(internal::View(pair.right), right, cv::COLOR_RGB2GRAY);
  const int low = static_cast<int>(std::floor(min_px)), high = static_cast<int>(std::ceil(max_px));
  RowOffset result;
  std::vector<double> offsets;
  for (const Window& window : TexturedWindows(left, kept, high, search)) {
    ++result.textured;
    const cv::Rect strip(window.at.x - high, window.at.y - search.rows, kWindow_px + high - low,
                         kWindow_px + 2 * search.rows);
    cv::Mat agreement;
    cv::matchTemplate(right(strip), left(window.at), agreement, cv::TM_CCOEFF_NORMED);
    double best = 0.0;
    cv::Point place;
    cv::minMaxLoc(agreement, nullptr, &best, nullptr, &place);
    if (best < kMinCorrelation) continue;
    offsets.push_back(place.y - search.rows);
    result.in_row += std::abs(offsets.back()) <= search.tolerance_px ? 1 : 0;
  }
  result.found = static_cast<int>(offsets.size());
  if (!offsets.empty()) result.median_px = base::MedianOf(offsets);
  return result;
}

void WriteStereoPictures(const Reconstruction& made, const std::filesystem::path& folder) {
  image::WritePng(folder / "rectified.png", RectifiedPicture(made.rectified));
  image::WritePng(folder / "disparity.png", DisparityPicture(made.disparity));
  image::WritePng(folder / "disparity16.png", EncodeDisparity(made.disparity));
}

}  // namespace rangegrasp::stereo
