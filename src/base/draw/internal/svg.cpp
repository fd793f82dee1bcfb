#include "base/draw/internal/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rangegrasp::draw::internal {
namespace {

// Room round a diagram for what is written there [px].
constexpr double kLeft = 70.0;
constexpr double kRight = 20.0;
constexpr double kTop = 30.0;
constexpr double kBottom = 45.0;
constexpr double kLabelX = 16.0;  // of a turned label at the left edge

// A range of one value: a tenth of it to both sides, or this.
constexpr double kMinHalfRange = 1e-9;
// Fewer say little, and twice as many with their numbers still fit.
constexpr double kMinTicks = 4.0;

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace

std::string Number(double value) { return fmt::format("{:.6g}", value); }

std::string Px(double value) { return fmt::format("{:.2f}", value); }

std::string Text(double x, double y, const std::string& text, const std::string& anchor,
                 const std::string& more) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, more, Escape(text));
}

std::string LineTo(double x1, double y1, double x2, double y2, const std::string& color,
                   double width) {
  return fmt::format(
      "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" "
      "stroke-width=\"{}\"/>\n",
      x1, y1, x2, y2, color, Number(width));
}

std::string Rect(double x, double y, double width, double height, const std::string& more) {
  return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"{}/>", x, y,
                     width, height, more);
}

std::string Head(int width, int height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      width, height);
}

void Range::Take(double value) {
  if (!std::isfinite(value)) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void Range::Widen(double share) {
  if (!(low <= high)) *this = {0.0, 1.0};
  const double air =
      low == high ? std::max(kMinHalfRange, std::abs(low) * 0.1) : share * (high - low);
  low -= air;
  high += air;
}

Frame FrameIn(double top, int width_px, int height_px) {
  return {{}, {}, kLeft, top + kTop, width_px - kLeft - kRight, height_px - kTop - kBottom};
}

std::vector<double> Ticks(double low, double high) {
  if (!(high > low)) return {low};
  const double rough = (high - low) / kMinTicks;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = power;
  for (const double factor : {2.0, 5.0}) {
    if (factor * power <= rough) step = factor * power;
  }
  std::vector<double> ticks;
  const double slack = 1e-9 * step;  // for ends that are round numbers themselves
  for (double k = std::ceil((low - slack) / step); k * step <= high + slack; k += 1.0) {
    ticks.push_back(k == 0.0 ? 0.0 : k * step);
  }
  return ticks;
}

std::string DrawYTicks(const Frame& frame) {
  std::string svg;
  for (const double tick : Ticks(frame.y.low, frame.y.high)) {
    svg += LineTo(frame.left, frame.Y(tick), frame.left + frame.width, frame.Y(tick), kGrid);
    svg += Text(frame.left - 6, frame.Y(tick) + 4, Number(tick), "end");
  }
  return svg;
}

std::string DrawYLabel(const Frame& frame, const std::string& label) {
  const double middle = frame.top + 0.5 * frame.height;
  return Text(kLabelX, middle, label, "middle",
              fmt::format(" transform=\"rotate(-90 {} {:.2f})\"", kLabelX, middle));
}

}  // namespace rangegrasp::draw::internal
