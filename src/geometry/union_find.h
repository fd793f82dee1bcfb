#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace rangegrasp::geometry {

/// Disjoint sets over 0 .. n - 1, by size with path halving (Tarjan 1975): near-constant time an
/// operation.
class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n), size_(n, 1) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  std::uint32_t Find(std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }

  /// Joins the sets of a and b; false if they were one already.
  bool Unite(std::uint32_t a, std::uint32_t b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return false;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
    return true;
  }

  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> size_;
};

/// Numbers the sets 0, 1, ... by descending count of their used members, ties by first member, into
/// `label` (-1 for members that are not used). Returns how many there are.
inline std::int32_t LabelBySize(UnionFind& sets, const std::vector<bool>& used,
                                std::vector<std::int32_t>& label) {
  const auto n = static_cast<std::uint32_t>(sets.size());
  std::vector<std::uint32_t> count(n, 0);
  std::vector<std::uint32_t> roots;  // in the order of their first members
  for (std::uint32_t i = 0; i < n; ++i) {
    if (used[i] && count[sets.Find(i)]++ == 0) roots.push_back(sets.Find(i));
  }
  std::stable_sort(roots.begin(), roots.end(),
                   [&count](std::uint32_t a, std::uint32_t b) { return count[a] > count[b]; });
  std::vector<std::int32_t> rank(n, -1);
  for (std::size_t k = 0; k < roots.size(); ++k) rank[roots[k]] = static_cast<std::int32_t>(k);
  label.assign(n, -1);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (used[i]) label[i] = rank[sets.Find(i)];
  }
  return static_cast<std::int32_t>(roots.size());
}

}  // namespace rangegrasp::geometry
