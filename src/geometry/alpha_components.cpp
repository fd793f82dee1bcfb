#include "geometry/alpha_components.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "geometry/alpha_shape.h"
#include "geometry/union_find.h"

namespace rangegrasp::geometry {
namespace {

// Two facts make the shortcut exact (up to rounding).
//
// 1. Let the ball on the diameter pq hold no point inside, and let r give the smallest circumradius
//    R of the triangles pqr. Then the smallest ball through p, q, r holds no point inside either:
//    move a ball through p and q from the first to this one; a point inside the last would have
//    been met on the way, at a smaller radius than R, and its triangle would have a smaller
//    circumradius. So pqr is in the complex if R <= alpha. All that matters lies within 2 R of p.
//
// 2. A triangle of the complex has sides <= 2 alpha, and its empty ball lies within 2 alpha of each
//    of its corners. If it joins two sets, each corner is within 2 alpha of a point of another set:
//    such triangles are found by a triangulation of the points within 2 alpha of those corners.

/// 21 bits a coordinate of a cube: cubes 2^21 apart share a number, which costs time, no more.
constexpr std::uint64_t kCubeMask = 0x1fffffu;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Neighbors that certificates are looked for among: on an even surface they reach two steps far.
/// The result does not depend on it: fewer leave more to the triangulation, more cost every point.
constexpr std::size_t kNeighbors = 12;
/// Above this share of points between sets the triangulation of all points is cheaper, since that
/// of a part takes in all within 2 alpha of it. The result does not depend on it.
constexpr double kMaxUndecided = 0.3;
/// Widens 2 alpha, since the tree leaves points at exactly the radius out; far more than rounding.
constexpr double kBeyond = 1.0 + 1e-9;
/// Shrinks a ball, so that rounding does not put a point on its surface inside.
constexpr double kInside = 1.0 - 1e-12;

class Finder {
 public:
  Finder(PointSpan points, const KdTree& tree, double alpha)
      : points_(points),
        tree_(tree),
        alpha_(alpha),
        sets_(points.size()),
        used_(points.size(), false),
        twin_(points.size()) {}

  AlphaComponents Find() {
    for (std::uint32_t i = 0; i < points_.size(); ++i) JoinNeighbors(i);
    JoinUndecided(Undecided());
    // A point is used if one of the same place is.
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (used_[i]) used_[twin_[i]] = true;
    }
    for (std::uint32_t i = 0; i < points_.size(); ++i) used_[i] = used_[twin_[i]];
    AlphaComponents result;
    result.components = LabelBySize(sets_, used_, result.component);
    return result;
  }

 private:
  void Use(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    used_[a] = used_[b] = used_[c] = true;
    sets_.Unite(a, b);
    sets_.Unite(a, c);
  }

  /// Fact 1 for p and its neighbors that are not yet joined with it.
  void JoinNeighbors(std::uint32_t p) {
    tree_.Nearest(points_[p], kNeighbors, list_);
    twin_[p] = list_.front().index;  // of those at distance 0 the smallest
    sets_.Unite(p, twin_[p]);
    const double reach = list_.size() < kNeighbors ? kInfinity : list_.back().squared_distance;
    for (const KdTree::Neighbor& q : list_) {
      if (q.squared_distance == 0.0) continue;
      if (q.squared_distance > 4.0 * alpha_ * alpha_) break;
      const bool joined = used_[p] && used_[q.index] && sets_.Find(p) == sets_.Find(q.index);
      if (!joined && IsGabriel(p, q)) JoinBest(p, q, reach);
    }
  }

  /// No point inside the ball on the diameter pq; such a point would be nearer to p than q is.
  bool IsGabriel(std::uint32_t p, const KdTree::Neighbor& q) const {
    const Eigen::Vector3d middle = 0.5 * (points_[p] + points_[q.index]);
    const double inside = 0.25 * q.squared_distance * kInside;
    for (const KdTree::Neighbor& s : list_) {
      if (s.squared_distance >= q.squared_distance) return true;
      if (s.squared_distance > 0.0 && (points_[s.index] - middle).squaredNorm() < inside) {
        return false;
      }
    }
    return true;
  }

  void JoinBest(std::uint32_t p, const KdTree::Neighbor& q, double squared_reach) {
    const Eigen::Vector3d pq = points_[q.index] - points_[p];
    double best = kInfinity;  // squared radius
    std::uint32_t best_r = 0;
    for (const KdTree::Neighbor& r : list_) {
      const Eigen::Vector3d pr = points_[r.index] - points_[p];
      const double area = pq.cross(pr).squaredNorm();
      const double sides = q.squared_distance * r.squared_distance *
                           (points_[r.index] - points_[q.index]).squaredNorm();
      if (!(area > 0.0) || !(sides < 4.0 * area * best)) continue;
      best = sides / (4.0 * area);
      best_r = r.index;
    }
    if (best <= alpha_ * alpha_ && 4.0 * best <= squared_reach) Use(p, q.index, best_r);
  }

  /// A number of 3 x 21 bits for the cube of side 2 alpha that p is in, moved by (x, y, z) cubes.
  std::uint64_t Cube(const Eigen::Vector3d& p, int x, int y, int z) const {
    const auto part = [this](double value, int shift) {
      return static_cast<std::uint64_t>(
                 static_cast<std::int64_t>(std::floor(value / (2.0 * alpha_))) + shift) &
             kCubeMask;
    };
    return part(p.x(), x) << 42 | part(p.y(), y) << 21 | part(p.z(), z);
  }

  /// The points within 2 alpha of a point of another set, ascending.
  Indices Undecided() {
    const auto rank = RankSets();
    std::unordered_map<std::uint64_t, std::uint32_t> highest;  // rank in each cube
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      auto& entry = highest[Cube(points_[i], 0, 0, 0)];
      entry = std::max(entry, rank[sets_.Find(i)]);
    }
    std::unordered_map<std::uint64_t, std::uint32_t> around;  // the same with the cubes round it
    std::vector<bool> undecided(points_.size(), false);
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      const auto [entry, is_new] = around.try_emplace(Cube(points_[i], 0, 0, 0), 0u);
      if (is_new) entry->second = HighestAround(points_[i], highest);
      // Of two sets the lower one looks for the other.
      if (rank[sets_.Find(i)] < entry->second) MarkOthers(i, undecided);
    }
    Indices list;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (undecided[i]) list.push_back(i);
    }
    return list;
  }

  /// Sets by ascending size.
  std::vector<std::uint32_t> RankSets() {
    std::vector<std::uint32_t> size(points_.size(), 0);
    for (std::uint32_t i = 0; i < points_.size(); ++i) ++size[sets_.Find(i)];
    Indices roots;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (size[i] > 0) roots.push_back(i);
    }
    std::stable_sort(roots.begin(), roots.end(),
                     [&size](std::uint32_t a, std::uint32_t b) { return size[a] < size[b]; });
    std::vector<std::uint32_t> rank(points_.size(), 0);
    for (std::uint32_t k = 0; k < roots.size(); ++k) rank[roots[k]] = k;
    return rank;
  }

  std::uint32_t HighestAround(
      const Eigen::Vector3d& p,
      const std::unordered_map<std::uint64_t, std::uint32_t>& highest) const {
    std::uint32_t best = 0;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const auto entry = highest.find(Cube(p, x, y, z));
          if (entry != highest.end()) best = std::max(best, entry->second);
        }
      }
    }
    return best;
  }

  void MarkOthers(std::uint32_t i, std::vector<bool>& undecided) {
    tree_.Within(points_[i], 2.0 * alpha_ * kBeyond, list_);
    const std::uint32_t set = sets_.Find(i);
    for (const KdTree::Neighbor& n : list_) {
      if (sets_.Find(n.index) == set) continue;
      undecided[i] = true;
      undecided[n.index] = true;
    }
  }

  /// Fact 2.
  void JoinUndecided(const Indices& undecided) {
    std::vector<bool> may_join(points_.size(), false);
    std::vector<bool> needed(points_.size(), false);
    const bool all =
        static_cast<double>(undecided.size()) > kMaxUndecided * static_cast<double>(points_.size());
    for (const std::uint32_t i : undecided) {
      may_join[i] = true;
      if (all) continue;
      tree_.Within(points_[i], 2.0 * alpha_ * kBeyond, list_);
      for (const KdTree::Neighbor& n : list_) needed[n.index] = true;
    }
    Indices subset;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (all || needed[i]) subset.push_back(i);
    }
    for (const auto& [a, b, c] : BuildAlphaComplex(Select(points_, subset), alpha_).triangles) {
      if (may_join[subset[a]] && may_join[subset[b]] && may_join[subset[c]]) {
        Use(subset[a], subset[b], subset[c]);
      }
    }
  }

  PointSpan points_;
  const KdTree& tree_;
  double alpha_;
  UnionFind sets_;
  std::vector<bool> used_;
  Indices twin_;  ///< the first point at the same place
  std::vector<KdTree::Neighbor> list_;
};

}  // namespace

AlphaComponents FindAlphaComponents(PointSpan points, const KdTree& tree, double alpha_m) {
  if (points.empty() || !(alpha_m > 0.0)) {
    return {std::vector<std::int32_t>(points.size(), -1), 0};
  }
  return Finder(points, tree, alpha_m).Find();
}

}  // namespace rangegrasp::geometry
