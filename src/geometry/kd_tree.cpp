#include "geometry/kd_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nanoflann.hpp>
#include <stdexcept>

#include "geometry/graph.h"

namespace rangegrasp::geometry {
namespace {

/// Points and their metric for nanoflann. The metric is nanoflann::L2_Simple_Adaptor without its
/// loop over axes, which is not a compile-time constant.
struct Adaptor {
  using ElementType = double;
  using DistanceType = double;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
  double evalMetric(const double* query, std::uint32_t i, std::size_t) const {
    const Eigen::Vector3d& p = points[i];
    const double dx = query[0] - p.x();
    const double dy = query[1] - p.y();
    const double dz = query[2] - p.z();
    return dx * dx + dy * dy + dz * dz;
  }
  double accum_dist(double a, double b, std::size_t) const { return (a - b) * (a - b); }

  PointSpan points;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<Adaptor, Adaptor, 3, std::uint32_t>;

/// nanoflann searches up to worstDist() and may stop if addPoint() returns false.
template <class Visit>
struct WithinSet {
  double squared_radius;
  Visit visit;  ///< visit(index, squared distance) returns whether to go on

  bool full() const { return true; }
  double worstDist() const { return squared_radius; }
  bool addPoint(double squared_distance, std::uint32_t index) {
    return !(squared_distance < squared_radius) || visit(index, squared_distance);
  }
};

bool Before(const KdTree::Neighbor& a, const KdTree::Neighbor& b) {
  return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
}

/// The k nearest within max_m in order, ties by index: a list, for small k faster than a heap.
class NearestSet {
 public:
  NearestSet(std::size_t k, double max_m, std::vector<KdTree::Neighbor>& out)
      : k_(k), out_(out), worst_(std::nextafter(max_m * max_m, kInfinity)) {}
  bool full() const { return out_.size() == k_; }
  double worstDist() const { return worst_; }
  bool addPoint(double squared_distance, std::uint32_t index) {
    const KdTree::Neighbor candidate{index, squared_distance};
    if (!full()) {
      out_.push_back(candidate);
    } else if (!Before(candidate, out_.back())) {
      return true;
    }
    std::size_t at = out_.size() - 1;
    for (; at > 0 && Before(candidate, out_[at - 1]); --at) out_[at] = out_[at - 1];
    out_[at] = candidate;
    // The next larger value, so that branches at exactly the worst distance are entered for ties.
    if (full()) worst_ = std::nextafter(out_.back().squared_distance, kInfinity);
    return true;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t k_;
  std::vector<KdTree::Neighbor>& out_;
  double worst_;
};

PointSpan CheckFinite(PointSpan points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw std::invalid_argument(fmt::format("KdTree: point {} is not finite", i));
    }
  }
  return points;
}

/// Points per leaf: fewer make the tree deep, more are scanned in vain; nanoflann advises 10 to 50.
constexpr std::size_t kLeafSize = 12;

}  // namespace

struct KdTree::Impl {
  explicit Impl(PointSpan points)
      : adaptor{CheckFinite(points)},
        tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  template <class Set>
  void Search(const Eigen::Vector3d& query, Set& set) const {
    // nanoflann would search a null root in an empty tree.
    if (!adaptor.points.empty()) tree.findNeighbors(set, query.data(), nanoflann::SearchParams());
  }

  Adaptor adaptor;
  Tree tree;
};

KdTree::KdTree(PointSpan points) : impl_(std::make_shared<Impl>(points)) {}

void KdTree::Nearest(const Eigen::Vector3d& query, std::size_t k, std::vector<Neighbor>& out,
                     double max_m) const {
  out.clear();
  if (k == 0) return;
  NearestSet set(k, max_m, out);
  impl_->Search(query, set);
}

void KdTree::Within(const Eigen::Vector3d& query, double radius_m,
                    std::vector<Neighbor>& out) const {
  out.clear();
  if (!(radius_m > 0.0)) return;
  WithinSet set{radius_m * radius_m, [&out](std::uint32_t index, double squared_distance) {
                  out.push_back({index, squared_distance});
                  return true;
                }};
  impl_->Search(query, set);
}

std::size_t KdTree::CountWithin(const Eigen::Vector3d& query, double radius_m,
                                std::size_t limit) const {
  if (!(radius_m > 0.0) || limit == 0) return 0;
  std::size_t count = 0;
  WithinSet set{radius_m * radius_m, [&](std::uint32_t, double) { return ++count < limit; }};
  impl_->Search(query, set);
  return count;
}

NeighborDistances NearestNeighborDistances(PointSpan points, const KdTree& tree) {
  if (points.size() < 2) {
    throw std::invalid_argument(
        fmt::format("NearestNeighborDistances: needs two points, got {}", points.size()));
  }
  NeighborDistances distances;
  std::vector<KdTree::Neighbor> nearest;
  double sum_m = 0.0;
  for (const Eigen::Vector3d& p : points) {
    tree.Nearest(p, 2, nearest);  // itself, and the nearest other point
    distances.each_m.push_back(std::sqrt(nearest.back().squared_distance));
    sum_m += distances.each_m.back();
  }
  distances.max_m = std::ranges::max(distances.each_m);
  distances.mean_m = sum_m / static_cast<double>(points.size());
  return distances;
}

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
