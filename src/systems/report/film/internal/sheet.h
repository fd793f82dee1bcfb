#pragma once

#include <string>
#include <vector>

#include "base/image/image.h"
#include "geometry/draw/canvas.h"

namespace rangegrasp::draw {

/// A picture with a caption below it.
struct Captioned {
  image::Image image;
  std::string caption;  ///< plain ASCII; other characters appear as '?'
};

/// All pictures on one sheet, in rows from left to right, with equal widths and their captions.
/// @param pictures  at least one
/// @param columns  maximum number of pictures in a row, >= 1
image::Image SheetOf(const std::vector<Captioned>& pictures, int columns, int tile_width_px);

/// A picture scaled to fit a width and a height, on white if its aspect ratio is different.
image::Image Fitted(const image::Image& picture, int width, int height);

/// Pastes a picture into another one at the position of its upper left corner, clipped.
void Paste(const image::Image& picture, int left, int top, image::Image& into);

/// Writes text with the left end of its baseline at (x, y) [px]; a scale of 1 is about 20 px high.
void WriteText(const std::string& text, int x, int y, double scale, image::Image& into);

/// A white picture.
image::Image Blank(int width, int height);

/// A quantity over time.
struct Trace {
  std::string label;  ///< with its unit: "grip force [N]"; plain ASCII
  std::vector<double> y;
  double at_least = 1.0;  ///< minimum upper end of the axis; larger values extend it
  Color color;
};

/// An event in time: a vertical line with its name.
struct Mark {
  double time_s = 0.0;
  std::string name;
};

/// Diagrams below each other over a common time axis from 0, drawn as pixels.
/// @param time_s  ascending, one for each value of a trace
image::Image DrawStrips(const std::vector<double>& time_s, const std::vector<Trace>& traces,
                        const std::vector<Mark>& marks, int width, int height);

}  // namespace rangegrasp::draw
