#pragma once

#include <string>
#include <vector>

#include "base/image/image.h"
#include "geometry/draw/canvas.h"

namespace rangegrasp::draw {

/// A quantity over time.
struct Trace {
  std::string label;  ///< with its unit: "grip force [N]"; plain ASCII
  std::vector<double> y;
  double at_least = 1.0;  ///< the axis reaches as far up, and further where the values do
  Color color;
};

/// What happens at a time: a vertical line with its name.
struct Mark {
  double time_s = 0.0;
  std::string name;
};

/// Diagrams one below the other over the same time from 0, drawn as pixels: for films, of which
/// each picture has one more value.
/// @param time_s  ascending, as many as each trace has values
image::Image DrawStrips(const std::vector<double>& time_s, const std::vector<Trace>& traces,
                        const std::vector<Mark>& marks, int width, int height);

}  // namespace rangegrasp::draw
