#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::draw {

/// A line or a set of dots in a panel; NaN interrupts the line.
struct Series {
  std::string label;  ///< legend entry; empty: not in the legend
  std::vector<double> x, y;
  std::string color = "#1f77b4";  ///< SVG color
  bool dots = false;
  double width_px = 1.2;
};

/// A vertical line at x with a label.
struct Marker {
  double x;
  std::string label;
  std::string color = "#d62728";
};

/// One diagram.
struct Panel {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  std::vector<Marker> markers;
  std::optional<std::pair<double, double>> y_range;  ///< absent: the range of the data
  bool equal_axes = false;                           ///< same scale on both axes
};

/// Round numbers for axis ticks within [low, high], 4 to 11 of them.
std::vector<double> Ticks(double low, double high);

/// Draws the panels below one another, as SVG.
std::string PlotSvg(const std::vector<Panel>& panels, int width_px = 900,
                    int panel_height_px = 260);

/// Grouped bars: values[series][group]; no bar is drawn for NaN.
struct BarChart {
  std::string title, y_label;
  std::vector<std::string> groups;
  std::vector<std::string> series;
  std::vector<std::vector<double>> values;
};

/// A bar chart as SVG.
std::string PlotSvg(const BarChart& chart, int width_px = 900, int height_px = 360);

}  // namespace rangegrasp::draw
