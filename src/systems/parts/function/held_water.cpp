#include "parts/function/held_water.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace rangegrasp::parts {
namespace {

constexpr double kUnseen = -std::numeric_limits<double>::infinity();

/// Heights of an upper side, with a rim of empty cells all round.
struct Heights {
  int columns = 0, rows = 0;
  double cell = 0.0;
  std::vector<double> z;

  std::size_t At(int i, int j) const { return static_cast<std::size_t>(j * columns + i); }
};

Heights UpperSide(geometry::PointSpan points, const Eigen::Vector3d& up, int cells) {
  const Eigen::Vector3d u = up.unitOrthogonal();
  const Eigen::Vector3d v = up.cross(u);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector2d q(u.dot(p), v.dot(p));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  Heights heights;
  heights.cell = (high - low).maxCoeff() / cells;
  if (!(heights.cell > 0.0)) return heights;
  heights.columns = 3 + static_cast<int>((high - low).x() / heights.cell);
  heights.rows = 3 + static_cast<int>((high - low).y() / heights.cell);
  heights.z.assign(static_cast<std::size_t>(heights.columns * heights.rows), kUnseen);
  for (const Eigen::Vector3d& p : points) {
    const auto i = 1 + static_cast<int>((u.dot(p) - low.x()) / heights.cell);
    const auto j = 1 + static_cast<int>((v.dot(p) - low.y()) / heights.cell);
    double& z = heights.z[heights.At(i, j)];
    z = std::max(z, up.dot(p));
  }
  return heights;
}

/// How high water stands over each cell.
std::vector<double> Levels(const Heights& heights) {
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  std::vector<double> level(heights.z.size(), 0.0);
  std::vector<bool> seen(heights.z.size(), false);
  seen[0] = true;
  level[0] = kUnseen;
  front.emplace(kUnseen, 0);
  while (!front.empty()) {
    const auto [water, at] = front.top();
    front.pop();
    const int i = static_cast<int>(at) % heights.columns;
    const int j = static_cast<int>(at) / heights.columns;
    for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (i + di < 0 || j + dj < 0 || i + di >= heights.columns || j + dj >= heights.rows) continue;
      const std::size_t next = heights.At(i + di, j + dj);
      if (seen[next]) continue;
      seen[next] = true;
      level[next] = std::max(water, heights.z[next]);
      front.emplace(level[next], next);
    }
  }
  return level;
}

}  // namespace

double HeldWater(geometry::PointSpan points, const Eigen::Vector3d& up, int cells) {
  const Heights heights = UpperSide(points, up, cells);
  if (heights.z.empty()) return 0.0;
  const std::vector<double> level = Levels(heights);
  double lowest = std::numeric_limits<double>::infinity();  // that is seen to hold water
  for (std::size_t k = 0; k < level.size(); ++k) {
    if (heights.z[k] > kUnseen && level[k] > heights.z[k]) lowest = std::min(lowest, heights.z[k]);
  }
  double volume = 0.0;
  for (std::size_t k = 0; k < level.size(); ++k) {
    if (level[k] == kUnseen) continue;
    const double floor = heights.z[k] > kUnseen ? heights.z[k] : std::min(lowest, level[k]);
    volume += (level[k] - floor) * heights.cell * heights.cell;
  }
  return volume;
}

}  // namespace rangegrasp::parts
