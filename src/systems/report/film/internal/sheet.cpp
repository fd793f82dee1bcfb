#include "report/film/internal/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace rangegrasp::draw {
namespace {

// Shares the pixels: the picture must outlive the result.
cv::Mat MatOf(image::Image& picture) {
  return {picture.height, picture.width, CV_8UC3, picture.rgb.data()};
}
// Read-only.
cv::Mat MatOf(const image::Image& picture) {
  return {picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.rgb.data())};
}

// Red, green, blue: the byte order of a picture, regardless of OpenCV's names.
using Rgb = cv::Scalar;

void Write(const std::string& text, int x, int y, double scale, image::Image& into,
           const Rgb& color) {
  cv::Mat mat = MatOf(into);
  cv::putText(mat, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, scale, color, 1, cv::LINE_AA);
}

// Captions: a letter is about 20 px high at a scale of 1.
constexpr double kLetters = 0.55;
constexpr int kCaption_px = 30;
constexpr int kBaseline_px = 9;  // of it below the baseline

// [px]
constexpr int kLeft = 46;
constexpr int kRight = 12;
constexpr int kTitle = 24;
constexpr int kBottom = 22;
constexpr double kChartLetters = 0.45;
// Minimum length of the time axis, so that a film's first second does not fill it [s].
constexpr double kMinTime_s = 10.0;

const Rgb kAxis(120, 120, 120);
const Rgb kMarked(200, 200, 200);

Rgb RgbOf(const Color& color) { return {255.0 * color.x(), 255.0 * color.y(), 255.0 * color.z()}; }

// Maps values to positions in the picture.
struct Axes {
  double end_s, top;
  cv::Rect area;

  cv::Point At(double time_s, double y) const {
    return {area.x + static_cast<int>(area.width * time_s / end_s),
            area.y + area.height - static_cast<int>(area.height * std::min(1.0, y / top))};
  }
};

void DrawMarks(const Axes& axes, const std::vector<Mark>& marks, bool named, image::Image& into) {
  cv::Mat mat = MatOf(into);
  int line = 0;
  for (const Mark& mark : marks) {
    cv::line(mat, axes.At(mark.time_s, 0.0), axes.At(mark.time_s, axes.top), kMarked);
    if (!named) continue;
    const cv::Point foot = axes.At(mark.time_s, 0.0);
    // Alternates between two lines, since stages may be short.
    const int y = axes.area.y + 12 + 12 * (line++ % 2);
    Write(mark.name, foot.x + 3, y, kChartLetters * 0.9, into, kAxis);
  }
}

void DrawTrace(const Axes& axes, const std::vector<double>& time_s, const Trace& trace,
               image::Image& into) {
  cv::Mat mat = MatOf(into);
  std::vector<cv::Point> line;
  for (std::size_t i = 0; i < time_s.size(); ++i) line.push_back(axes.At(time_s[i], trace.y[i]));
  cv::polylines(mat, line, /*isClosed=*/false, RgbOf(trace.color), 2, cv::LINE_AA);
  cv::line(mat, axes.At(0.0, 0.0), axes.At(axes.end_s, 0.0), kAxis);
  cv::line(mat, axes.At(0.0, 0.0), axes.At(0.0, axes.top), kAxis);
  Write(fmt::format("{:.3g}", axes.top), 4, axes.area.y + 10, kChartLetters, into, kAxis);
  Write("0", kLeft - 14, axes.area.y + axes.area.height, kChartLetters, into, kAxis);
  const std::string now = trace.y.empty() ? "" : fmt::format("  {:.3g}", trace.y.back());
  Write(trace.label + now, kLeft, axes.area.y - 8, kChartLetters, into, RgbOf(trace.color));
}

}  // namespace

image::Image Blank(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(3 * image::IndexAt(0, height, width), 255)};
}

void Paste(const image::Image& picture, int left, int top, image::Image& into) {
  const cv::Rect whole(0, 0, into.width, into.height);
  const cv::Rect place = cv::Rect(left, top, picture.width, picture.height) & whole;
  if (place.empty()) return;
  MatOf(picture)(place - cv::Point(left, top)).copyTo(MatOf(into)(place));
}

image::Image Fitted(const image::Image& picture, int width, int height) {
  const double scale = std::min(static_cast<double>(width) / picture.width,
                                static_cast<double>(height) / picture.height);
  image::Image small = Blank(std::max(1, static_cast<int>(scale * picture.width)),
                             std::max(1, static_cast<int>(scale * picture.height)));
  cv::Mat to = MatOf(small);
  cv::resize(MatOf(picture), to, to.size(), 0.0, 0.0, cv::INTER_AREA);
  image::Image fitted = Blank(width, height);
  Paste(small, (width - small.width) / 2, (height - small.height) / 2, fitted);
  return fitted;
}

void WriteText(const std::string& text, int x, int y, double scale, image::Image& into) {
  Write(text, x, y, scale, into, {30, 30, 30});
}

image::Image SheetOf(const std::vector<Captioned>& pictures, int columns, int tile_width_px) {
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
    WriteText(one.caption, left + kBaseline_px, top + tile_height_px + kCaption_px - kBaseline_px,
              kLetters, sheet);
  }
  return sheet;
}

image::Image DrawStrips(const std::vector<double>& time_s, const std::vector<Trace>& traces,
                        const std::vector<Mark>& marks, int width, int height) {
  image::Image picture = Blank(width, height);
  const double end_s = std::max(kMinTime_s, time_s.empty() ? 0.0 : time_s.back());
  const int each = (height - kBottom) / std::max(1, static_cast<int>(traces.size()));
  for (std::size_t i = 0; i < traces.size(); ++i) {
    const int top = static_cast<int>(i) * each;
    double value = traces[i].at_least;
    for (const double y : traces[i].y) value = std::max(value, y);
    const Axes axes{end_s, value, {kLeft, top + kTitle, width - kLeft - kRight, each - kTitle - 6}};
    DrawMarks(axes, marks, i == 0, picture);
    DrawTrace(axes, time_s, traces[i], picture);
  }
  Write("0 s", kLeft, height - 6, kChartLetters, picture, kAxis);
  Write(fmt::format("{:.1f} s", end_s), width - 60, height - 6, kChartLetters, picture, kAxis);
  return picture;
}

}  // namespace rangegrasp::draw
