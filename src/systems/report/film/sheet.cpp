#include "report/film/sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "report/film/internal/mat.h"

namespace rangegrasp::draw {
namespace {

// Captions: a letter is about 20 px high at a scale of 1.
constexpr double kLetters = 0.55;
constexpr int kCaption_px = 30;
constexpr int kBaseline_px = 9;  // of it below the letters' feet

}  // namespace

image::Image Blank(int width, int height) {
  const auto bytes = 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return {width, height, std::vector<std::uint8_t>(bytes, 255)};
}

void Paste(const image::Image& picture, int left, int top, image::Image& into) {
  const cv::Rect whole(0, 0, into.width, into.height);
  const cv::Rect place = cv::Rect(left, top, picture.width, picture.height) & whole;
  if (place.empty()) return;
  internal::MatOf(picture)(place - cv::Point(left, top)).copyTo(internal::MatOf(into)(place));
}

image::Image Fitted(const image::Image& picture, int width, int height) {
  const double scale = std::min(static_cast<double>(width) / picture.width,
                                static_cast<double>(height) / picture.height);
  image::Image small = Blank(std::max(1, static_cast<int>(scale * picture.width)),
                             std::max(1, static_cast<int>(scale * picture.height)));
  cv::Mat to = internal::MatOf(small);
  cv::resize(internal::MatOf(picture), to, to.size(), 0.0, 0.0, cv::INTER_AREA);
  image::Image fitted = Blank(width, height);
  Paste(small, (width - small.width) / 2, (height - small.height) / 2, fitted);
  return fitted;
}

void WriteText(const std::string& text, int x, int y, double scale, image::Image& into) {
  internal::Write(text, x, y, scale, into);
}

image::Image SheetOf(const std::vector<Captioned>& pictures, int columns, int tile_width_px) {
  if (pictures.empty()) throw std::invalid_argument("SheetOf: needs a picture");
  int tile_height_px = 0;
  for (const Captioned& one : pictures) {
    tile_height_px = std::max(tile_height_px, tile_width_px * one.image.height / one.image.width);
  }
  const int count = static_cast<int>(pictures.size());
  const int across = std::min(columns, count);
  const int down = (count + across - 1) / across;
  image::Image sheet = Blank(across * tile_width_px, down * (tile_height_px + kCaption_px));
  for (int i = 0; i < count; ++i) {
    const Captioned& one = pictures[static_cast<std::size_t>(i)];
    const int left = i % across * tile_width_px;
    const int top = i / across * (tile_height_px + kCaption_px);
    Paste(Fitted(one.image, tile_width_px, tile_height_px), left, top, sheet);
    internal::Write(one.caption, left + kBaseline_px,
                    top + tile_height_px + kCaption_px - kBaseline_px, kLetters, sheet);
  }
  return sheet;
}

}  // namespace rangegrasp::draw
