#include "seam/internal/even_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"

namespace rangegrasp::seam {
namespace {

// Times the usual distance of neighbouring points: two points with one or more missing between
// them are further apart, points on slopes that a sensor sees are nearer.
constexpr double kGap = 1.5;
// A column takes the height of a point up to half the distance of two away, and what rounding adds.
constexpr double kNear = 0.5 * (1.0 + 1e-9);
// A line with more is a mistake in the unit or an outlier in x.
constexpr double kMaxGridColumns = 65536.0;

struct GridPoint {
  double x_m;
  float height_m;
};

// Those with a height, by x.
std::vector<GridPoint> PointsOf(const RawRow& row) {
  std::vector<GridPoint> points;
  for (std::size_t i = 0; i < row.x_m.size(); ++i) {
    if (std::isfinite(row.x_m[i]) && std::isfinite(row.height_m[i])) {
      points.push_back({row.x_m[i], row.height_m[i]});
    }
  }
  std::ranges::stable_sort(points, {}, &GridPoint::x_m);
  return points;
}

// Of neighbours: the mean of the distances that are no gap, which numbers that were rounded to a
// few digits do not shift along the line as a median would. 0 if there are fewer than two places.
double UsualDistance(const std::vector<GridPoint>& points) {
  std::vector<double> distances;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double distance = points[i].x_m - points[i - 1].x_m;
    if (distance > 0.0) distances.push_back(distance);
  }
  if (distances.empty()) return 0.0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  const double longest = kGap * *middle;
  std::erase_if(distances, [longest](double distance) { return distance > longest; });
  return std::accumulate(distances.begin(), distances.end(), 0.0) /
         static_cast<double>(distances.size());
}

}  // namespace

std::optional<EvenGrid> GridOf(std::span<const RawRow> rows, double columns_per_m) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double pitch = columns_per_m > 0.0 ? 1.0 / columns_per_m : 0.0;
  for (const RawRow& row : rows) {
    const auto points = PointsOf(row);
    if (points.size() < 2) continue;
    low = std::min(low, points.front().x_m);
    high = std::max(high, points.back().x_m);
    if (pitch == 0.0) pitch = UsualDistance(points);
  }
  if (!(pitch > 0.0) || !(high > low)) return std::nullopt;
  const double columns = std::round((high - low) / pitch) + 1.0;
  if (columns > kMaxGridColumns) {
    throw base::InputError(fmt::format(
        "x from {:.6g} to {:.6g} m with {:.6g} columns a metre are {:.0f} columns; at most {:.0f} "
        "are a line (a wrong unit, or a no-value among x?)",
        low, high, 1.0 / pitch, columns, kMaxGridColumns));
  }
  return EvenGrid{low, pitch, static_cast<std::size_t>(columns)};
}

std::vector<float> OnGrid(const RawRow& row, const EvenGrid& grid) {
  std::vector<float> heights(grid.columns, std::numeric_limits<float>::quiet_NaN());
  const auto points = PointsOf(row);
  const double typical = UsualDistance(points);
  const double near = kNear * std::max(typical, grid.pitch_m);
  std::size_t next = 0;  // the first point at or behind the column
  for (std::size_t column = 0; column < grid.columns; ++column) {
    const double x = grid.first_m + static_cast<double>(column) * grid.pitch_m;
    while (next < points.size() && points[next].x_m < x) ++next;
    const GridPoint* right = next < points.size() ? &points[next] : nullptr;
    const GridPoint* left = next > 0 ? &points[next - 1] : nullptr;
    if (left != nullptr && right != nullptr && right->x_m - left->x_m <= kGap * typical) {
      const double share = (x - left->x_m) / (right->x_m - left->x_m);
      heights[column] = static_cast<float>((1.0 - share) * static_cast<double>(left->height_m) +
                                           share * static_cast<double>(right->height_m));
    } else if (right != nullptr && right->x_m - x <= near) {
      heights[column] = right->height_m;
    } else if (left != nullptr && x - left->x_m <= near) {
      heights[column] = left->height_m;
    }
  }
  return heights;
}

}  // namespace rangegrasp::seam
