#include "perception/point_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::KdTree;
using geometry::Points;
using geometry::PointSpan;

/// Every pass but the last removes a point, and far outliers hide nearer ones in a few layers: a
/// bound on time, not on what is found.
constexpr int kMaxPasses = 20;

/// The state of the filter: the points that are left, and how far each is from the nearest of them.
class Filter {
 public:
  Filter(PointSpan points, const KdTree& tree, const OutlierFilterOptions& options)
      : points_(points),
        tree_(tree),
        options_(options),
        kept_(points.size(), true),
        nearest_m_(geometry::NearestNeighborDistances(points, tree).each_m) {}

  /// Removes what eq. 4.5-4.9 call outliers among the points left; false if there was none.
  bool Pass() {
    if (points_.size() < removed_ + 2) return false;
    const CompressionRate rate = Rate();
    Indices outliers;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (kept_[i] && Removes(i, rate)) outliers.push_back(i);
    }
    if (outliers.empty()) return false;
    Remove(outliers);
    return true;
  }

  Indices Kept() const {
    Indices kept;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (kept_[i]) kept.push_back(i);
    }
    return kept;
  }

 private:
  CompressionRate Rate() const {
    double min_m = std::numeric_limits<double>::infinity();
    double max_m = 0.0;
    double sum_m = 0.0;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (!kept_[i]) continue;
      min_m = std::min(min_m, nearest_m_[i]);
      max_m = std::max(max_m, nearest_m_[i]);
      sum_m += nearest_m_[i];
    }
    return ComputeCompressionRate(min_m, max_m,
                                  sum_m / static_cast<double>(points_.size() - removed_));
  }

  /// The count of kept points within the radius, or `limit` if it is larger.
  std::size_t CountKept(const Eigen::Vector3d& p, double radius_m, std::size_t limit) {
    const std::size_t enough = limit + removed_;
    const std::size_t count = tree_.CountWithin(p, radius_m, enough);
    if (count >= enough || removed_ == 0) return std::min(count, limit);
    tree_.Within(p, radius_m, neighbors_);
    const auto kept = std::count_if(neighbors_.begin(), neighbors_.end(),
                                    [this](const KdTree::Neighbor& n) { return kept_[n.index]; });
    return std::min(static_cast<std::size_t>(kept), limit);
  }

  /// Counts only as far as the answer needs: from N_a >= N_k d_a / d_k on a point is not isolated,
  /// and an isolated one with beta <= 1 is no outlier (alpha > beta^tau >= beta).
  bool Removes(std::uint32_t i, const CompressionRate& rate) {
    if (nearest_m_[i] < options_.keep_m) return false;
    const Eigen::Vector3d& p = points_[i];
    const std::size_t n_k =
        nearest_m_[i] < rate.d_k_m ? CountKept(p, rate.d_k_m, points_.size()) : 1;
    if (!options_.isolated_only) {
      return IsOutlier(rate, CountKept(p, rate.d_a_m, points_.size()), n_k, options_.unit_m);
    }
    if (OutlierBeta(rate, n_k, options_.unit_m) <= 1.0) return false;
    const auto enough = static_cast<std::size_t>(static_cast<double>(n_k) / rate.tau) + 1;
    const std::size_t n_a = CountKept(p, rate.d_a_m, enough);
    return IsIsolated(rate, n_a, n_k) && IsOutlier(rate, n_a, n_k, options_.unit_m);
  }

  /// A point whose nearest neighbor goes is at least as far from it as that was from its own
  /// nearest: all others keep their distance.
  void Remove(const Indices& outliers) {
    double min_m = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : outliers) {
      kept_[i] = false;
      min_m = std::min(min_m, nearest_m_[i]);
    }
    removed_ += outliers.size();
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (kept_[i] && nearest_m_[i] >= min_m) nearest_m_[i] = DistanceToKept(i);
    }
  }

  double DistanceToKept(std::uint32_t i) {
    for (std::size_t k = 4;; k *= 2) {  // itself, and mostly one of three that is kept
      tree_.Nearest(points_[i], k, neighbors_);
      for (const KdTree::Neighbor& n : neighbors_) {
        if (n.index != i && kept_[n.index]) return std::sqrt(n.squared_distance);
      }
      if (neighbors_.size() < k) return nearest_m_[i];  // the last point left
    }
  }

  PointSpan points_;
  const KdTree& tree_;
  const OutlierFilterOptions options_;
  std::vector<bool> kept_;
  std::size_t removed_ = 0;
  std::vector<double> nearest_m_;
  std::vector<KdTree::Neighbor> neighbors_;
};

}  // namespace

CompressionRate ComputeCompressionRate(double d_min_m, double d_max_m, double d_mean_m) {
  CompressionRate rate;
  rate.d_a_m = (d_min_m + d_max_m) / 2.0;
  rate.d_k_m = d_mean_m;
  rate.tau = rate.d_k_m / rate.d_a_m;
  return rate;
}

double OutlierAlpha(const CompressionRate& rate, std::size_t n_a, double unit_m) {
  return std::pow(rate.d_a_m / unit_m / static_cast<double>(n_a), rate.tau);
}

double OutlierBeta(const CompressionRate& rate, std::size_t n_k, double unit_m) {
  return rate.d_k_m / unit_m / static_cast<double>(n_k);
}

bool IsOutlier(const CompressionRate& rate, std::size_t n_a, std::size_t n_k, double unit_m) {
  return OutlierAlpha(rate, n_a, unit_m) < OutlierBeta(rate, n_k, unit_m);
}

bool IsIsolated(const CompressionRate& rate, std::size_t n_a, std::size_t n_k) {
  return rate.d_a_m / static_cast<double>(n_a) > rate.d_k_m / static_cast<double>(n_k);
}

Indices CompressionRateFilter(PointSpan points, const OutlierFilterOptions& options) {
  return CompressionRateFilter(points, KdTree(points), options);
}

Indices CompressionRateFilter(PointSpan points, const KdTree& tree,
                              const OutlierFilterOptions& options) {
  Indices all(points.size());
  std::iota(all.begin(), all.end(), 0u);
  if (points.size() < 2) return all;
  Filter filter(points, tree, options);
  const int max_passes = options.repeated ? kMaxPasses : 1;
  for (int pass = 0; pass < max_passes && filter.Pass(); ++pass) {
  }
  return filter.Kept();
}

Points Smooth(PointSpan points, double radius_m) {
  return Smooth(points, KdTree(points), radius_m);
}

Points Smooth(PointSpan points, const KdTree& tree, double radius_m) {
  Points smoothed(points.begin(), points.end());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius_m, neighbors);
    if (neighbors.size() < 2) continue;
    // Offsets from the point itself, so that a point with no spread round it stays as it is.
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    for (const KdTree::Neighbor& n : neighbors) shift += points[n.index] - points[i];
    smoothed[i] += shift / static_cast<double>(neighbors.size());
  }
  return smoothed;
}

}  // namespace rangegrasp::perception
