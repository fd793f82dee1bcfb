#pragma once

#include <string>
#include <vector>

#include "base/image/image.h"
#include "geometry/draw/canvas.h"

namespace rangegrasp::draw {

/// A picture and what stands below it.
struct Captioned {
  image::Image image;
  std::string caption;  ///< plain ASCII: what is none shows as '?'
};

/// The pictures as one, in rows from the left, each as wide as all others and with its caption.
/// @param columns  at most so many in a row, >= 1
/// @throws std::invalid_argument without pictures.
image::Image SheetOf(const std::vector<Captioned>& pictures, int columns, int tile_width_px);

/// A picture within a width and a height, on white where its shape is another one.
image::Image Fitted(const image::Image& picture, int width, int height);

/// Puts a picture into another at a place of its upper left corner; what juts out is cut off.
void Paste(const image::Image& picture, int left, int top, image::Image& into);

/// Letters with their feet's left end at (x, y) [px]; a scale of 1 is about 20 px high.
void WriteText(const std::string& text, int x, int y, double scale, image::Image& into);

/// A white picture.
image::Image Blank(int width, int height);

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

/// Diagrams one below the other over the same time from 0, drawn as pixels.
/// @param time_s  ascending, as many as each trace has values
image::Image DrawStrips(const std::vector<double>& time_s, const std::vector<Trace>& traces,
                        const std::vector<Mark>& marks, int width, int height);

}  // namespace rangegrasp::draw
