#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

/// From sensed edge points to the needle's path. All points are in frame M: x across, y along.
namespace rangegrasp::seam {

using Point = Eigen::Vector2d;

/// Smooths sensed points, many of which may be gross outliers. Each point moves to a local parabola
/// that most of its neighbors support, in the window around or next to it with the smallest
/// expected variance; without a well-supported parabola it is dropped. No window has to reach
/// across a jump of the edge, so corners stay sharp. O(n w^4) for w <= 12 points in a window.
/// @param sensed  ascending in y.
/// @return ascending in y; empty for fewer than 5 points.
std::vector<Point> SmoothEdge(std::span<const Point> sensed);

/// Extends the smoothed edge at both ends in a straight line by the given lengths.
std::vector<Point> Extend(std::vector<Point> edge, double before_m, double after_m);

/// x at y of the curve at a distance from the edge, on its low side (smaller x): the outline of all
/// discs of this radius around points of the edge. NaN if there is no edge within the distance.
/// @param edge  a polyline ascending in y.
double OffsetX(std::span<const Point> edge, double distance_m, double y_m);

/// Points at equal distances along a polyline; the last one may be closer.
std::vector<Point> Resample(std::span<const Point> line, double spacing_m);

/// Rounds a polyline with equal spacing: each point becomes the mean of itself and `half` (fewer at
/// the ends) neighbors on each side. End points do not move.
std::vector<Point> RoundCorners(std::span<const Point> line, int half);

}  // namespace rangegrasp::seam
