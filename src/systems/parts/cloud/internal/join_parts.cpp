#include "parts/cloud/internal/join_parts.h"

#include <algorithm>
#include <limits>

namespace rangegrasp::parts {
namespace {

/// For each part the number of the set that it is in.
std::vector<std::int32_t> NumberSets(const std::vector<double>& area, geometry::UnionFind& sets) {
  std::vector<double> of_set(area.size(), 0.0);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t l = 0; l < area.size(); ++l) {
    of_set[sets.Find(l)] += area[l];
    if (sets.Find(l) == l) roots.push_back(l);
  }
  std::stable_sort(roots.begin(), roots.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return of_set[a] > of_set[b]; });
  std::vector<std::int32_t> of_root(area.size()), number;
  for (std::size_t k = 0; k < roots.size(); ++k) of_root[roots[k]] = static_cast<std::int32_t>(k);
  for (std::uint32_t l = 0; l < area.size(); ++l) number.push_back(of_root[sets.Find(l)]);
  return number;
}

std::vector<PartNode> FlatTree(const Segmentation& found, int parts) {
  std::vector<PartNode> tree = {found.tree.front()};
  if (parts == 1) {
    tree.front().label = 0;
    return tree;
  }
  tree.front().label = -1;
  for (std::int32_t l = 0; l < parts; ++l) {
    tree.push_back({0, 1, l, std::numeric_limits<double>::infinity()});
  }
  return tree;
}

}  // namespace

Segmentation JoinParts(const Segmentation& found, const std::vector<double>& area,
                       geometry::UnionFind& sets) {
  const std::vector<std::int32_t> number = NumberSets(area, sets);
  Segmentation joined = found;
  for (std::int32_t& l : joined.label) l = number[static_cast<std::size_t>(l)];
  joined.parts = *std::max_element(number.begin(), number.end()) + 1;
  joined.has_core = joined.parts > 1;
  joined.tree = FlatTree(found, joined.parts);
  return joined;
}

}  // namespace rangegrasp::parts
