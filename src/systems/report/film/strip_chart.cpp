#include "report/film/strip_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "report/film/internal/mat.h"
#include "report/film/sheet.h"

namespace rangegrasp::draw {
namespace {

// [px]
constexpr int kLeft = 46;
constexpr int kRight = 12;
constexpr int kTitle = 24;
constexpr int kBottom = 22;
constexpr double kChartLetters = 0.45;
/// The axis of time is at least so long, so that a film's first second does not fill it [s].
constexpr double kMinTime_s = 10.0;

const internal::Rgb kAxis(120, 120, 120);
const internal::Rgb kMarked(200, 200, 200);

internal::Rgb RgbOf(const Color& color) {
  return {255.0 * color.x(), 255.0 * color.y(), 255.0 * color.z()};
}

/// Where values stand in the picture.
struct Axes {
  double end_s, top;
  cv::Rect area;

  cv::Point At(double time_s, double y) const {
    return {area.x + static_cast<int>(area.width * time_s / end_s),
            area.y + area.height - static_cast<int>(area.height * std::min(1.0, y / top))};
  }
};

double TopOf(const Trace& trace) {
  double top = trace.at_least;
  for (const double y : trace.y) top = std::max(top, y);
  return top;
}

void DrawMarks(const Axes& axes, const std::vector<Mark>& marks, bool named, image::Image& into) {
  cv::Mat mat = internal::MatOf(into);
  int line = 0;
  for (const Mark& mark : marks) {
    cv::line(mat, axes.At(mark.time_s, 0.0), axes.At(mark.time_s, axes.top), kMarked);
    if (!named) continue;
    const cv::Point foot = axes.At(mark.time_s, 0.0);
    // In turn on two lines: stages may be short.
    const int y = axes.area.y + 12 + 12 * (line++ % 2);
    internal::Write(mark.name, foot.x + 3, y, kChartLetters * 0.9, into, kAxis);
  }
}

void DrawTrace(const Axes& axes, const std::vector<double>& time_s, const Trace& trace,
               image::Image& into) {
  cv::Mat mat = internal::MatOf(into);
  std::vector<cv::Point> line;
  for (std::size_t i = 0; i < time_s.size(); ++i) line.push_back(axes.At(time_s[i], trace.y[i]));
  cv::polylines(mat, line, /*isClosed=*/false, RgbOf(trace.color), 2, cv::LINE_AA);
  cv::line(mat, axes.At(0.0, 0.0), axes.At(axes.end_s, 0.0), kAxis);
  cv::line(mat, axes.At(0.0, 0.0), axes.At(0.0, axes.top), kAxis);
  internal::Write(fmt::format("{:.3g}", axes.top), 4, axes.area.y + 10, kChartLetters, into, kAxis);
  internal::Write("0", kLeft - 14, axes.area.y + axes.area.height, kChartLetters, into, kAxis);
  const std::string now = trace.y.empty() ? "" : fmt::format("  {:.3g}", trace.y.back());
  internal::Write(trace.label + now, kLeft, axes.area.y - 8, kChartLetters, into,
                  RgbOf(trace.color));
}

}  // namespace

image::Image DrawStrips(const std::vector<double>& time_s, const std::vector<Trace>& traces,
                        const std::vector<Mark>& marks, int width, int height) {
  image::Image picture = Blank(width, height);
  const double end_s = std::max(kMinTime_s, time_s.empty() ? 0.0 : time_s.back());
  const int each = (height - kBottom) / std::max(1, static_cast<int>(traces.size()));
  for (std::size_t i = 0; i < traces.size(); ++i) {
    const int top = static_cast<int>(i) * each;
    const Axes axes{
        end_s, TopOf(traces[i]), {kLeft, top + kTitle, width - kLeft - kRight, each - kTitle - 6}};
    DrawMarks(axes, marks, i == 0, picture);
    DrawTrace(axes, time_s, traces[i], picture);
  }
  internal::Write("0 s", kLeft, height - 6, kChartLetters, picture, kAxis);
  internal::Write(fmt::format("{:.1f} s", end_s), width - 60, height - 6, kChartLetters, picture,
                  kAxis);
  return picture;
}

}  // namespace rangegrasp::draw
