#include "geometry/groups.h"

#include <cstdint>
#include <map>

#include "geometry/union_find.h"

namespace rangegrasp::geometry {

std::vector<Indices> GroupsWithin(PointSpan points, const KdTree& tree, double link_m) {
  UnionFind sets(points.size());
  std::vector<KdTree::Neighbor> near;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], link_m, near);
    for (const auto& neighbor : near) sets.Unite(i, neighbor.index);
  }
  std::vector<Indices> groups;
  std::map<std::uint32_t, std::size_t> group_of;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto [group, is_new] = group_of.try_emplace(sets.Find(i), groups.size());
    if (is_new) groups.emplace_back();
    groups[group->second].push_back(i);
  }
  return groups;
}

std::vector<Points> GroupsWithin(const Points& points, double link_m) {
  std::vector<Points> groups;
  for (const Indices& group : GroupsWithin(points, KdTree(points), link_m)) {
    groups.push_back(Select(points, group));
  }
  return groups;
}

}  // namespace rangegrasp::geometry
