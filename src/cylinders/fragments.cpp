#include "cylinders/fragments.h"

#include <algorithm>

#include "geometry/groups.h"

namespace rangegrasp::cylinders {

double MeanNearestDistance(geometry::PointSpan points, const geometry::KdTree& tree) {
  return points.size() < 2 ? 0.0 : geometry::NearestNeighborDistances(points, tree).mean_m;
}

std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options) {
  if (points.empty()) return {};
  const geometry::KdTree tree(points);
  auto groups =
      geometry::GroupsWithin(points, tree, options.link * MeanNearestDistance(points, tree));
  std::erase_if(groups, [&](const geometry::Indices& group) {
    return group.size() < static_cast<std::size_t>(options.min_points);
  });
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

}  // namespace rangegrasp::cylinders
