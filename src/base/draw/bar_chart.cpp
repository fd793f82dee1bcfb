#include "base/draw/bar_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "base/draw/internal/svg.h"

namespace rangegrasp::draw {
namespace {

using internal::Frame;
using internal::kInk;
using internal::LineTo;
using internal::Text;

// One for each series, in turn; told apart by most eyes (the category colors of common plotters).
constexpr std::array kColors = {"#1f77b4", "#ff7f0e", "#2ca02c", "#d62728",
                                "#9467bd", "#8c564b", "#e377c2", "#7f7f7f"};
constexpr double kLegend_px = 20.0;  // between title and bars
constexpr double kBarAir = 1.05;     // of the highest bar
constexpr double kGroupShare = 0.8;  // of a group's room is bars, the rest is between groups
constexpr double kBarShare = 0.95;   // of a bar's room
constexpr double kLetter_px = 7.0;   // about a letter's width

const char* ColorOf(std::size_t series) { return kColors[series % kColors.size()]; }

void Check(const BarChart& chart) {
  if (chart.values.size() != chart.series.size()) {
    throw std::invalid_argument("bar chart: one list of values a series");
  }
  for (const auto& values : chart.values) {
    if (values.size() == chart.groups.size()) continue;
    throw std::invalid_argument("bar chart: one value a group");
  }
}

Frame FrameOf(const BarChart& chart, int width_px, int height_px) {
  Frame frame = internal::FrameIn(0.0, width_px, height_px);
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
      svg += internal::Rect(left + static_cast<double>(s) * bar_width, frame.Y(value),
                            kBarShare * bar_width, frame.Y(0.0) - frame.Y(value),
                            fmt::format(" fill=\"{}\"", ColorOf(s))) +
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

std::string PlotSvg(const BarChart& chart, int width_px, int height_px) {
  Check(chart);
  const Frame frame = FrameOf(chart, width_px, height_px);
  const double right = frame.left + frame.width;
  std::string svg = internal::Head(width_px, height_px) + internal::DrawYTicks(frame);
  svg += Text(0.5 * width_px, 18, chart.title, "middle", internal::kBold);
  svg += internal::DrawYLabel(frame, chart.y_label) + DrawBars(chart, frame);
  svg += LineTo(frame.left, frame.Y(0.0), right, frame.Y(0.0), kInk);
  return svg + DrawLegend(chart, frame) + "</svg>\n";
}

}  // namespace rangegrasp::draw
