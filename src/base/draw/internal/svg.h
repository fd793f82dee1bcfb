#pragma once

#include <limits>
#include <string>
#include <vector>

namespace rangegrasp::draw::internal {

constexpr char kInk[] = "#444";   ///< of axes and frames
constexpr char kGrid[] = "#ddd";  ///< of lines across a diagram
constexpr char kBold[] = " font-weight=\"bold\"";

/// Six digits of a number.
std::string Number(double value);
/// A length in pixels, which need no more than two digits after the point.
std::string Px(double value);

/// Elements of a picture; `more` are further attributes.
std::string Text(double x, double y, const std::string& text, const std::string& anchor = "middle",
                 const std::string& more = "");
std::string LineTo(double x1, double y1, double x2, double y2, const std::string& color,
                   double width = 1.0);
std::string Rect(double x, double y, double width, double height, const std::string& more = "");

/// The picture's first lines, with a white ground; "</svg>" must follow.
std::string Head(int width, int height);

/// An interval that grows with what it takes.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void Take(double value);   ///< NaN and infinity are left out
  void Widen(double share);  ///< by a share of itself at both ends; never empty afterwards
};

/// Where a diagram lies in the picture: from data to pixels.
struct Frame {
  Range x, y;
  double left, top, width, height;

  double X(double value) const { return left + (value - x.low) / (x.high - x.low) * width; }
  double Y(double value) const { return top + (y.high - value) / (y.high - y.low) * height; }
  double Bottom() const { return top + height; }
};

/// A frame with room for titles, numbers and labels round it, in a part of the picture that begins
/// `top` pixels below its upper edge.
Frame FrameIn(double top, int width_px, int height_px);

/// Round numbers within [low, high], 4 to 11 of them.
std::vector<double> Ticks(double low, double high);

/// Lines across at round numbers, with those at the left.
std::string DrawYTicks(const Frame& frame);
/// What the vertical axis shows, turned.
std::string DrawYLabel(const Frame& frame, const std::string& label);

}  // namespace rangegrasp::draw::internal
