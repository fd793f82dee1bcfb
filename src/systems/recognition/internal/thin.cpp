#include "recognition/internal/thin.h"

#include <cmath>
#include <cstdint>
#include <unordered_set>

namespace rangegrasp::recognition::internal {

geometry::Indices Thinned(geometry::PointSpan points, double edge_m) {
  constexpr std::int64_t kHalf = 1 << 20;  // cells a side of the origin: 21 bits an axis
  std::unordered_set<std::int64_t> taken;
  geometry::Indices kept;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    std::int64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = key << 21 | (static_cast<std::int64_t>(std::floor(points[i][axis] / edge_m)) + kHalf);
    }
    if (taken.insert(key).second) kept.push_back(i);
  }
  return kept;
}

}  // namespace rangegrasp::recognition::internal
