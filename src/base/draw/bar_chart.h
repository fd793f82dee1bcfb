#pragma once

#include <string>
#include <vector>

namespace rangegrasp::draw {

/// Bars in groups: values[series][group]; NaN draws no bar.
struct BarChart {
  std::string title, y_label;
  std::vector<std::string> groups;
  std::vector<std::string> series;
  std::vector<std::vector<double>> values;
};

/// A bar chart as SVG. @throws std::invalid_argument if the sizes do not fit.
std::string PlotSvg(const BarChart& chart, int width_px = 900, int height_px = 360);

}  // namespace rangegrasp::draw
