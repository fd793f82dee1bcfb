#include "cylinders/fragments.h"

#include <algorithm>
#include <cmath>

#include "geometry/groups.h"

namespace rangegrasp::cylinders {

double MeanNearestDistance(geometry::PointSpan points, const geometry::KdTree& tree) {
  return points.size() < 2 ? 0.0 : geometry::NearestNeighborDistances(points, tree).mean_m;
}

double MeanNeighborDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                            double radius_m) {
  double sum_m = 0.0;
  std::size_t count = 0;
  std::vector<geometry::KdTree::Neighbor> near;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius_m, near);
    double of_one = 0.0;
    for (const auto& neighbor : near) of_one += std::sqrt(neighbor.squared_distance);
    if (near.size() < 2) continue;  // itself
    sum_m += of_one / static_cast<double>(near.size() - 1);
    ++count;
  }
  return count == 0 ? 0.0 : sum_m / static_cast<double>(count);
}

double LinkDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                    const FragmentOptions& options) {
  return options.link > 0.0 ? options.link * MeanNearestDistance(points, tree)
                            : MeanNeighborDistance(points, tree, options.neighborhood_m);
}

std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options) {
  if (points.empty()) return {};
  const geometry::KdTree tree(points);
  auto groups = geometry::GroupsWithin(points, tree, LinkDistance(points, tree, options));
  std::erase_if(groups, [&](const geometry::Indices& group) {
    return group.size() < static_cast<std::size_t>(options.min_points);
  });
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

}  // namespace rangegrasp::cylinders
