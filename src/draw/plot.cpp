#include "draw/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

constexpr double kLeft = 70.0;
constexpr double kRight = 20.0;
constexpr double kTop = 30.0;
constexpr double kBottom = 45.0;
constexpr std::array kColors = {"#1f77b4", "#ff7f0e", "#2ca02c", "#d62728",
                                "#9467bd", "#8c564b", "#e377c2", "#7f7f7f"};

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

// Pixels need no more digits than this.
std::string Px(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  return text.data();
}

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

std::string Text(double x, double y, const std::string& text, const std::string& anchor = "middle",
                 const std::string& more = "") {
  return "<text x=\"" + Px(x) + "\" y=\"" + Px(y) + "\" text-anchor=\"" + anchor + "\"" + more +
         ">" + Escape(text) + "</text>\n";
}

std::string LineTo(double x1, double y1, double x2, double y2, const std::string& color,
                   double width = 1.0) {
  return "<line x1=\"" + Px(x1) + "\" y1=\"" + Px(y1) + "\" x2=\"" + Px(x2) + "\" y2=\"" + Px(y2) +
         "\" stroke=\"" + color + "\" stroke-width=\"" + Number(width) + "\"/>\n";
}

std::string Head(int width, int height) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(width) +
         "\" height=\"" + std::to_string(height) +
         "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
         "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void Take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  // Never empty, with a little air.
  void Widen(double share) {
    if (!(low <= high)) *this = {0.0, 1.0};
    const double air = low == high ? std::max(1e-9, std::abs(low) * 0.1) : share * (high - low);
    low -= air;
    high += air;
  }
};

// From data to pixels.
struct Frame {
  Range x, y;
  double left, top, width, height;

  double X(double value) const { return left + (value - x.low) / (x.high - x.low) * width; }
  double Y(double value) const { return top + (y.high - value) / (y.high - y.low) * height; }
};

Frame FrameOf(const Panel& panel, double top, int width_px, int height_px) {
  Frame frame{{}, {}, kLeft, top + kTop, width_px - kLeft - kRight, height_px - kTop - kBottom};
  for (const Series& series : panel.series) {
    for (const double x : series.x) frame.x.Take(x);
    for (const double y : series.y) frame.y.Take(y);
  }
  frame.x.Widen(0.0);
  if (panel.y_range) {
    frame.y = {panel.y_range->first, panel.y_range->second};
  } else {
    frame.y.Widen(0.06);
  }
  if (panel.equal_axes) {
    const double unit = std::max((frame.x.high - frame.x.low) / frame.width,
                                 (frame.y.high - frame.y.low) / frame.height);
    const auto centre = [unit](Range& range, double pixels) {
      const double middle = 0.5 * (range.low + range.high);
      range = {middle - 0.5 * unit * pixels, middle + 0.5 * unit * pixels};
    };
    centre(frame.x, frame.width);
    centre(frame.y, frame.height);
  }
  return frame;
}

std::string DrawAxes(const Panel& panel, const Frame& frame) {
  const double bottom = frame.top + frame.height;
  std::string svg = "<rect x=\"" + Px(frame.left) + "\" y=\"" + Px(frame.top) + "\" width=\"" +
                    Px(frame.width) + "\" height=\"" + Px(frame.height) +
                    "\" fill=\"none\" stroke=\"#444\"/>\n";
  for (const double tick : Ticks(frame.x.low, frame.x.high)) {
    svg += LineTo(frame.X(tick), bottom, frame.X(tick), bottom + 4, "#444");
    svg += Text(frame.X(tick), bottom + 17, Number(tick));
  }
  for (const double tick : Ticks(frame.y.low, frame.y.high)) {
    svg += LineTo(frame.left, frame.Y(tick), frame.left + frame.width, frame.Y(tick), "#ddd");
    svg += Text(frame.left - 6, frame.Y(tick) + 4, Number(tick), "end");
  }
  const double middle = frame.top + 0.5 * frame.height;
  svg += Text(frame.left + 0.5 * frame.width, frame.top - 10, panel.title, "middle",
              " font-weight=\"bold\"");
  svg += Text(frame.left + 0.5 * frame.width, bottom + 34, panel.x_label);
  svg +=
      Text(16, middle, panel.y_label, "middle", " transform=\"rotate(-90 16 " + Px(middle) + ")\"");
  return svg;
}

std::string DrawSeries(const Series& series, const Frame& frame) {
  std::string svg;
  std::string points;
  const auto end_line = [&] {
    if (!points.empty()) {
      svg += "<polyline fill=\"none\" stroke=\"" + series.color + "\" stroke-width=\"" +
             Number(series.width_px) + "\" points=\"" + points + "\"/>\n";
    }
    points.clear();
  };
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      end_line();
      continue;
    }
    const std::string x = Px(frame.X(series.x[i]));
    const std::string y = Px(frame.Y(series.y[i]));
    if (series.dots) {
      svg += "<circle cx=\"" + x + "\" cy=\"" + y + "\" r=\"" + Number(series.width_px) +
             "\" fill=\"" + series.color + "\"/>\n";
    } else {
      points += x + "," + y + " ";
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
    y += 15;
  }
  return svg;
}

std::string DrawMarkers(const Panel& panel, const Frame& frame) {
  std::string svg;
  double y = frame.top + 14;
  for (const Marker& marker : panel.markers) {
    const double x = frame.X(marker.x);
    svg += LineTo(x, frame.top, x, frame.top + frame.height, marker.color, 1.5);
    svg += Text(x + 4, y, marker.label, "start", " fill=\"" + marker.color + "\"");
    y += 14;  // labels of near marks stay readable
  }
  return svg;
}

}  // namespace

std::vector<double> Ticks(double low, double high) {
  if (!(high > low)) return {low};
  const double rough = (high - low) / 4.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = power;
  for (const double factor : {2.0, 5.0}) {
    if (factor * power <= rough) step = factor * power;
  }
  std::vector<double> ticks;
  const double slack = 1e-9 * step;
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
    const std::string id = "panel" + std::to_string(i);
    svg += DrawAxes(panels[i], frame);
    svg += "<clipPath id=\"" + id + "\"><rect x=\"" + Px(frame.left) + "\" y=\"" + Px(frame.top) +
           "\" width=\"" + Px(frame.width) + "\" height=\"" + Px(frame.height) +
           "\"/></clipPath>\n<g clip-path=\"url(#" + id + ")\">\n";
    for (const Series& series : panels[i].series) svg += DrawSeries(series, frame);
    svg += "</g>\n" + DrawMarkers(panels[i], frame) + DrawLegend(panels[i], frame);
    top += panel_height_px;
  }
  return svg + "</svg>\n";
}

std::string PlotSvg(const BarChart& chart, int width_px, int height_px) {
  if (chart.values.size() != chart.series.size()) {
    throw std::invalid_argument("bar chart: one list of values a series");
  }
  Panel axes;
  axes.title = chart.title;
  axes.y_label = chart.y_label;
  Frame frame{
      {0.0, 1.0}, {}, kLeft, kTop + 20, width_px - kLeft - kRight, height_px - kTop - kBottom - 20};
  frame.y.Take(0.0);
  for (const auto& values : chart.values) {
    if (values.size() != chart.groups.size()) {
      throw std::invalid_argument("bar chart: one value a group");
    }
    for (const double value : values) frame.y.Take(value);
  }
  if (frame.y.high == 0.0) frame.y.high = 1.0;
  frame.y.high *= 1.05;
  std::string svg = Head(width_px, height_px);
  for (const double tick : Ticks(frame.y.low, frame.y.high)) {
    svg += LineTo(frame.left, frame.Y(tick), frame.left + frame.width, frame.Y(tick), "#ddd");
    svg += Text(frame.left - 6, frame.Y(tick) + 4, Number(tick), "end");
  }
  svg += Text(0.5 * width_px, 18, chart.title, "middle", " font-weight=\"bold\"");
  const double middle = frame.top + 0.5 * frame.height;
  svg +=
      Text(16, middle, chart.y_label, "middle", " transform=\"rotate(-90 16 " + Px(middle) + ")\"");
  const double group_width =
      frame.width / static_cast<double>(std::max<std::size_t>(1, chart.groups.size()));
  const double bar_width =
      0.8 * group_width / static_cast<double>(std::max<std::size_t>(1, chart.series.size()));
  for (std::size_t group = 0; group < chart.groups.size(); ++group) {
    const double left = frame.left + (static_cast<double>(group) + 0.1) * group_width;
    for (std::size_t s = 0; s < chart.series.size(); ++s) {
      const double value = chart.values[s][group];
      if (!std::isfinite(value)) continue;
      svg += "<rect x=\"" + Px(left + static_cast<double>(s) * bar_width) + "\" y=\"" +
             Px(frame.Y(value)) + "\" width=\"" + Px(0.95 * bar_width) + "\" height=\"" +
             Px(frame.Y(0.0) - frame.Y(value)) + "\" fill=\"" + kColors[s % kColors.size()] +
             "\"/>\n";
    }
    svg += Text(left + 0.4 * group_width, frame.top + frame.height + 17, chart.groups[group]);
  }
  svg += LineTo(frame.left, frame.Y(0.0), frame.left + frame.width, frame.Y(0.0), "#444");
  double x = frame.left;
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    svg += LineTo(x, frame.top - 8, x + 16, frame.top - 8, kColors[s % kColors.size()], 8.0);
    svg += Text(x + 22, frame.top - 4, chart.series[s], "start");
    x += 40.0 + 7.0 * static_cast<double>(chart.series[s].size());
  }
  return svg + "</svg>\n";
}

}  // namespace rangegrasp::draw
