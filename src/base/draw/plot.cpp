#include "base/draw/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/draw/internal/svg.h"

namespace rangegrasp::draw {
namespace {

using internal::Frame;
using internal::kInk;
using internal::LineTo;
using internal::Number;
using internal::Px;
using internal::Range;
using internal::Text;

constexpr double kAir = 0.06;      // of the data's range, above and below it
constexpr double kLine_px = 15.0;  // from a line of text to the next

Frame FrameOf(const Panel& panel, double top, int width_px, int height_px) {
  Frame frame = internal::FrameIn(top, width_px, height_px);
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
  std::string svg = internal::Rect(frame.left, frame.top, frame.width, frame.height,
                                   fmt::format(" fill=\"none\" stroke=\"{}\"", kInk)) +
                    "\n";
  for (const double tick : internal::Ticks(frame.x.low, frame.x.high)) {
    svg += LineTo(frame.X(tick), frame.Bottom(), frame.X(tick), frame.Bottom() + 4, kInk);
    svg += Text(frame.X(tick), frame.Bottom() + 17, Number(tick));
  }
  svg += internal::DrawYTicks(frame);
  svg += Text(middle, frame.top - 10, panel.title, "middle", internal::kBold);
  svg += Text(middle, frame.Bottom() + 34, panel.x_label);
  return svg + internal::DrawYLabel(frame, panel.y_label);
}

std::string DrawSeries(const Series& series, const Frame& frame) {
  std::string svg;
  std::string points;
  const auto end_line = [&] {
    if (!points.empty()) {
      svg +=
          fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" points=\"{}\"/>\n",
                      series.color, Number(series.width_px), points);
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
      svg += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>\n", x, y,
                         Number(series.width_px), series.color);
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
    y += kLine_px - 1;  // labels of near marks stay readable
  }
  return svg;
}

std::string DrawPanel(const Panel& panel, const Frame& frame, const std::string& id) {
  std::string svg = DrawAxes(panel, frame);
  svg += fmt::format("<clipPath id=\"{}\">{}</clipPath>\n<g clip-path=\"url(#{})\">\n", id,
                     internal::Rect(frame.left, frame.top, frame.width, frame.height), id);
  for (const Series& series : panel.series) svg += DrawSeries(series, frame);
  return svg + "</g>\n" + DrawMarkers(panel, frame) + DrawLegend(panel, frame);
}

}  // namespace

std::string PlotSvg(const std::vector<Panel>& panels, int width_px, int panel_height_px) {
  std::string svg = internal::Head(width_px, panel_height_px * static_cast<int>(panels.size()));
  double top = 0.0;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Frame frame = FrameOf(panels[i], top, width_px, panel_height_px);
    svg += DrawPanel(panels[i], frame, fmt::format("panel{}", i));
    top += panel_height_px;
  }
  return svg + "</svg>\n";
}

}  // namespace rangegrasp::draw
