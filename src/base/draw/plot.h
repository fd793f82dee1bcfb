#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::draw {

/// One line (or set of dots) of a panel; NaN interrupts a line.
struct Series {
  std::string label;  ///< in the legend; empty: not there
  std::vector<double> x, y;
  std::string color = "#1f77b4";  ///< as in SVG
  bool dots = false;
  double width_px = 1.2;
};

/// A vertical mark at x.
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
  std::optional<std::pair<double, double>> y_range;  ///< of the data if absent
  bool equal_axes = false;                           ///< one unit is as long on both axes
};

/// Round numbers within [low, high], 4 to 11 of them.
std::vector<double> Ticks(double low, double high);

/// Panels one below the other, as SVG.
std::string PlotSvg(const std::vector<Panel>& panels, int width_px = 900,
                    int panel_height_px = 260);

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
