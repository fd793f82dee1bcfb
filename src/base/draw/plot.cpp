#include "base/draw/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/words.h"

namespace rangegrasp::draw {
namespace {

constexpr char kInk[] = "#444";   // axes and frames
constexpr char kGrid[] = "#ddd";  // grid lines
constexpr char kBold[] = " font-weight=\"bold\"";
// Margins around a diagram for its text [px].
constexpr double kLeft = 70.0;
constexpr double kRight = 20.0;
constexpr double kTop = 30.0;
constexpr double kBottom = 45.0;
constexpr double kLabelX = 16.0;  // x of the rotated label at the left edge

// A range of one value is widened by a tenth of it on both sides, or at least by this.
constexpr double kMinHalfRange = 1e-9;
// Fewer ticks say little, and twice as many with their numbers still fit.
constexpr double kMinTicks = 4.0;

constexpr double kAir = 0.06;      // margin above and below the data, as a share of their range
constexpr double kLine_px = 15.0;  // text line spacing

// Colors of the series, in turn: the category colors of common plotting tools.
constexpr std::array kColors = {"#1f77b4", "#ff7f0e", "#2ca02c", "#d62728",
                                "#9467bd", "#8c564b", "#e377c2", "#7f7f7f"};
constexpr double kLegend_px = 20.0;  // space for the legend between title and bars
constexpr double kBarAir = 1.05;     // height of the axis relative to the highest bar
constexpr double kGroupShare = 0.8;  // share of bars in a group's width, the rest is space
constexpr double kBarShare = 0.95;   // share of a bar in its width
constexpr double kLetter_px = 7.0;   // approximate letter width

/// An interval that grows to include values.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  /// Ignores NaN and infinity.
  void Take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// Widens both ends by a share of the range; the range is never empty afterwards.
  void Widen(double share) {
    if (!(low <= high)) *this = {0.0, 1.0};
    const double air =
        low == high ? std::max(kMinHalfRange, std::abs(low) * 0.1) : share * (high - low);
    low -= air;
    high += air;
  }
};

/// Position of a diagram in the picture; maps data to pixels.
struct Frame {
  Range x, y;
  double left, top, width, height;

  double X(double value) const { return left + (value - x.low) / (x.high - x.low) * width; }
  double Y(double value) const { return top + (y.high - value) / (y.high - y.low) * height; }
  double Bottom() const { return top + height; }
};

std::string Number(double value) { return fmt::format("{:g}", value); }

std::string Text(double x, double y, const std::string& text, const std::string& anchor = "middle",
                 const std::string& more = "") {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, more, base::XmlEscaped(text));
}

std::string LineTo(double x1, double y1, double x2, double y2, const std::string& color,
                   double width = 1.0) {
  return fmt::format(
      "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" "
      "stroke-width=\"{:g}\"/>\n",
      x1, y1, x2, y2, color, width);
}

std::string Rect(double x, double y, double width, double height, const std::string& more = "") {
  return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"{}/>", x, y,
                     width, height, more);
}

std::string Rect(const Frame& frame, const std::string& more = "") {
  return Rect(frame.left, frame.top, frame.width, frame.height, more);
}

/// The first lines of the SVG, with a white background; "</svg>" must follow.
std::string Head(int width, int height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      width, height);
}

/// A frame with margins for titles, numbers and labels, `top` pixels below the upper edge.
Frame FrameIn(double top, int width_px, int height_px) {
  return {{}, {}, kLeft, top + kTop, width_px - kLeft - kRight, height_px - kTop - kBottom};
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

Frame FrameOf(const Panel& panel, double top, int width_px, int height_px) {
  Frame frame = FrameIn(top, width_px, height_px);
  for (const Series& series : panel.series) {
    for (const double x : series.x) frame.x.Take(x);
    for (const double y : series.y) frame.y.Take(y);
  }
  frame.x.Widen(0.0);
  if (panel.y_range) {
    frame.y = {panel.y_range->first, panel.y_range->second};
  } else {
    frame.y.Widen(kAir);
  }
  if (panel.equal_axes) {
    const double unit = std::max((frame.x.high - frame.x.low) / frame.width,
                                 (frame.y.high - frame.y.low) / frame.height);
    const auto center = [unit](Range& range, double pixels) {
      const double middle = 0.5 * (range.low + range.high);
      range = {middle - 0.5 * unit * pixels, middle + 0.5 * unit * pixels};
    };
    center(frame.x, frame.width);
    center(frame.y, frame.height);
  }
  return frame;
}

std::string DrawAxes(const Panel& panel, const Frame& frame) {
  const double middle = frame.left + 0.5 * frame.width;
  std::string svg = Rect(frame, fmt::format(" fill=\"none\" stroke=\"{}\"", kInk)) + "\n";
  for (const double tick : Ticks(frame.x.low, frame.x.high)) {
    svg += LineTo(frame.X(tick), frame.Bottom(), frame.X(tick), frame.Bottom() + 4, kInk);
    svg += Text(frame.X(tick), frame.Bottom() + 17, Number(tick));
  }
  svg += DrawYTicks(frame);
  svg += Text(middle, frame.top - 10, panel.title, "middle", kBold);
  svg += Text(middle, frame.Bottom() + 34, panel.x_label);
  return svg + DrawYLabel(frame, panel.y_label);
}

std::string DrawSeries(const Series& series, const Frame& frame) {
  std::string svg;
  std::string points;
  const auto end_line = [&] {
    if (!points.empty()) {
      svg += fmt::format(
          "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" points=\"{}\"/>\n",
          series.color, series.width_px, points);
    }
    points.clear();
  };
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      end_line();
      continue;
    }
    const double x = frame.X(series.x[i]), y = frame.Y(series.y[i]);
    if (series.dots) {
      svg += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:g}\" fill=\"{}\"/>\n", x, y,
                         series.width_px, series.color);
    } else {
      points += fmt::format("{:.2f},{:.2f} ", x, y);
    }
  }
  end_line();
  return svg;
}

std::string DrawLegend(const Panel& panel, const Frame& frame) {
  std::string svg;
  double y = frame.top + 16;
  for (const Series& series : panel.series) {
    if (series.label.empty()) continue;
    svg += LineTo(frame.left + 10, y - 4, frame.left + 30, y - 4, series.color, 3.0);
    svg += Text(frame.left + 36, y, series.label, "start");
    y += kLine_px;
  }
  return svg;
}

std::string DrawMarkers(const Panel& panel, const Frame& frame) {
  std::string svg;
  double y = frame.top + 14;
  for (const Marker& marker : panel.markers) {
    const double x = frame.X(marker.x);
    svg += LineTo(x, frame.top, x, frame.Bottom(), marker.color, 1.5);
    svg += Text(x + 4, y, marker.label, "start", fmt::format(" fill=\"{}\"", marker.color));
    y += kLine_px - 1;  // keeps labels of close markers readable
  }
  return svg;
}

std::string DrawPanel(const Panel& panel, const Frame& frame, const std::string& id) {
  std::string svg = DrawAxes(panel, frame);
  svg += fmt::format("<clipPath id=\"{}\">{}</clipPath>\n<g clip-path=\"url(#{})\">\n", id,
                     Rect(frame), id);
  for (const Series& series : panel.series) svg += DrawSeries(series, frame);
  return svg + "</g>\n" + DrawMarkers(panel, frame) + DrawLegend(panel, frame);
}

const char* ColorOf(std::size_t series) { return kColors[series % kColors.size()]; }

Frame FrameOf(const BarChart& chart, int width_px, int height_px) {
  Frame frame = FrameIn(0.0, width_px, height_px);
  frame.x = {0.0, 1.0};
  frame.top += kLegend_px;
  frame.height -= kLegend_px;
  frame.y.Take(0.0);
  for (const auto& values : chart.values) {
    for (const double value : values) frame.y.Take(value);
  }
  if (frame.y.high == 0.0) frame.y.high = 1.0;
  frame.y.high *= kBarAir;
  return frame;
}

std::string DrawBars(const BarChart& chart, const Frame& frame) {
  const auto room = [](double width, std::size_t parts) {
    return width / static_cast<double>(std::max<std::size_t>(1, parts));
  };
  const double group_width = room(frame.width, chart.groups.size());
  const double bar_width = room(kGroupShare * group_width, chart.series.size());
  std::string svg;
  for (std::size_t group = 0; group < chart.groups.size(); ++group) {
    const double left = frame.left + (static_cast<double>(group) + 0.1) * group_width;
    for (std::size_t s = 0; s < chart.series.size(); ++s) {
      const double value = chart.values[s][group];
      if (!std::isfinite(value)) continue;
      svg += Rect(left + static_cast<double>(s) * bar_width, frame.Y(value), kBarShare * bar_width,
                  frame.Y(0.0) - frame.Y(value), fmt::format(" fill=\"{}\"", ColorOf(s))) +
             "\n";
    }
    svg += Text(left + 0.5 * kGroupShare * group_width, frame.Bottom() + 17, chart.groups[group]);
  }
  return svg;
}

std::string DrawLegend(const BarChart& chart, const Frame& frame) {
  std::string svg;
  double x = frame.left;
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    svg += LineTo(x, frame.top - 8, x + 16, frame.top - 8, ColorOf(s), 8.0);
    svg += Text(x + 22, frame.top - 4, chart.series[s], "start");
    x += 40.0 + kLetter_px * static_cast<double>(chart.series[s].size());
  }
  return svg;
}

}  // namespace

std::vector<double> Ticks(double low, double high) {
  if (!(high > low)) return {low};
  const double rough = (high - low) / kMinTicks;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = power;
  for (const double factor : {2.0, 5.0}) {
    if (factor * power <= rough) step = factor * power;
  }
  std::vector<double> ticks;
  const double slack = 1e-9 * step;  // includes ends that are round numbers themselves
  for (double k = std::ceil((low - slack) / step); k * step <= high + slack; k += 1.0) {
    ticks.push_back(k == 0.0 ? 0.0 : k * step);
  }
  return ticks;
}

std::string PlotSvg(const std::vector<Panel>& panels, int width_px, int panel_height_px) {
  std::string svg = Head(width_px, panel_height_px * static_cast<int>(panels.size()));
  double top = 0.0;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Frame frame = FrameOf(panels[i], top, width_px, panel_height_px);
    svg += DrawPanel(panels[i], frame, fmt::format("panel{}", i));
    top += panel_height_px;
  }
  return svg + "</svg>\n";
}

std::string PlotSvg(const BarChart& chart, int width_px, int height_px) {
  const Frame frame = FrameOf(chart, width_px, height_px);
  const double right = frame.left + frame.width;
  std::string svg = Head(width_px, height_px) + DrawYTicks(frame);
  svg += Text(0.5 * width_px, 18, chart.title, "middle", kBold);
  svg += DrawYLabel(frame, chart.y_label) + DrawBars(chart, frame);
  svg += LineTo(frame.left, frame.Y(0.0), right, frame.Y(0.0), kInk);
  return svg + DrawLegend(chart, frame) + "</svg>\n";
}

}  // namespace rangegrasp::draw
