#include "perception/preprocess.h"

#include <limits>
#include <numeric>
#include <ranges>

namespace rangegrasp::perception {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using geometry::KdTree;
using geometry::Plane;
using geometry::Points;
using geometry::PointSpan;
using geometry::TriangleMesh;

struct Candidate {
  Plane plane;
  Vector3d center;
  double area = 0.0;
};

Plane TowardsSensor(const Plane& plane, const Vector3d& sensor_origin) {
  return plane.Distance(sensor_origin) >= 0.0 ? plane : plane.Flipped();
}

bool IsUp(const Plane& plane, const PreprocessOptions& options) {
  return !options.up_C ||
         plane.normal.dot(options.up_C->normalized()) >= std::cos(options.table.max_tilt_rad);
}

std::vector<Candidate> HullPlanes(const TriangleMesh& hull, const Vector3d& sensor_origin,
                                  const PreprocessOptions& options) {
  std::vector<Candidate> faces;
  for (const auto& [a, b, c] : hull.triangles) {
    // Outward faces are counter-clockwise; with two vertices swapped, the normal points inside.
    const auto plane = geometry::PlaneThrough(hull.vertices[a], hull.vertices[c], hull.vertices[b]);
    if (!plane || plane->Distance(sensor_origin) <= 0.0 || !IsUp(*plane, options)) continue;
    const Vector3d u = hull.vertices[b] - hull.vertices[a];
    const Vector3d v = hull.vertices[c] - hull.vertices[a];
    faces.push_back({*plane, (hull.vertices[a] + hull.vertices[b] + hull.vertices[c]) / 3.0,
                     0.5 * u.cross(v).norm()});
  }
  std::ranges::stable_sort(faces, std::ranges::greater(), &Candidate::area);
  const double same_cosine = std::cos(options.table.same_plane_rad);
  const double same_distance_m = options.table.same_plane_share * options.preselection_m;
  std::vector<Candidate> merged;
  for (const Candidate& face : faces) {
    const bool known = std::ranges::any_of(merged, [&](const Candidate& other) {
      return face.plane.normal.dot(other.plane.normal) > same_cosine &&
             std::abs(other.plane.Distance(face.center)) < same_distance_m;
    });
    if (!known) merged.push_back(face);
  }
  return merged;
}

Points Thinned(PointSpan points, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  Points thinned;
  for (std::size_t i = 0; i < points.size(); i += step) thinned.push_back(points[i]);
  return thinned;
}

std::size_t CountNear(PointSpan points, const Plane& plane, double distance_m) {
  return static_cast<std::size_t>(std::ranges::count_if(
      points, [&](const Vector3d& p) { return std::abs(plane.Distance(p)) <= distance_m; }));
}

/// The candidate with the most points near it.
std::optional<Plane> DeepestPlane(PointSpan points, const std::vector<Candidate>& candidates,
                                  const PreprocessOptions& options) {
  const double distance_m = options.preselection_m;
  const Points some = Thinned(points, options.table.ranking_points);
  using Ranked = std::pair<std::size_t, Plane>;
  std::vector<Ranked> ranking;
  for (const Candidate& one : candidates) {
    ranking.emplace_back(CountNear(some, one.plane, distance_m), one.plane);
  }
  std::ranges::stable_sort(ranking, std::ranges::greater(), &Ranked::first);
  std::optional<Plane> best;
  std::size_t best_count = 0;
  for (const auto& [ranked, plane] : ranking | std::views::take(options.table.finalists)) {
    const std::size_t count = CountNear(points, plane, distance_m);
    if (count <= best_count) continue;
    best_count = count;
    best = plane;
  }
  return best;
}

Points Near(PointSpan points, const Plane& plane, double distance_m) {
  return geometry::Select(points, geometry::PositionsWhere(points, [&](const Vector3d& p) {
                            return std::abs(plane.Distance(p)) <= distance_m;
                          }));
}

/// Preselects, draws hypotheses and refits (section 5.1.1); refits again, because the hull's plane
/// may be tilted so far that its preselection misses part of the table. The normal keeps its side.
std::optional<Plane> FitNear(PointSpan points, const Plane& plane, const PreprocessOptions& options,
                             base::Rng& rng) {
  const auto fit = geometry::FitPlaneRansac(
      Near(Thinned(points, options.table.ranking_points), plane, options.preselection_m),
      {options.plane_draws, options.plane_distance_m}, rng);
  if (!fit) return std::nullopt;
  const auto refit = geometry::FitPlane(Near(points, fit->plane, options.plane_distance_m));
  return geometry::TurnedLike(plane, refit.value_or(fit->plane));
}

bool IsTable(PointSpan points, const Plane& plane, const PreprocessOptions& options) {
  const std::size_t on = CountNear(points, plane, options.plane_distance_m);
  const auto below = std::ranges::count_if(
      points, [&](const Vector3d& p) { return plane.Distance(p) < -options.preselection_m; });
  const auto n = static_cast<double>(points.size());
  return static_cast<double>(on) >= options.table.min_support * n &&
         static_cast<double>(below) <= options.table.max_below * n;
}

Points Peel(Points points, const TriangleMesh& hull) {
  const auto before = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  Points vertices = hull.vertices;
  std::ranges::sort(vertices, before);
  std::erase_if(points,
                [&](const Vector3d& p) { return std::ranges::binary_search(vertices, p, before); });
  return points;
}

/// Section 5.1.1: the deepest plane of the hull.
std::optional<Plane> PlaneUnderAll(PointSpan points, const Vector3d& sensor_origin,
                                   const PreprocessOptions& options, base::Rng& rng) {
  Points rest = Thinned(points, options.table.hull_points);
  const int peelings = options.robust_table ? options.table.peelings : 0;
  for (int peeling = 0; peeling <= peelings; ++peeling) {
    const TriangleMesh hull = geometry::ConvexHull(rest);
    if (hull.triangles.empty()) break;
    const auto deepest = DeepestPlane(points, HullPlanes(hull, sensor_origin, options), options);
    const auto plane = deepest ? FitNear(points, *deepest, options, rng) : std::nullopt;
    if (plane && plane->Distance(sensor_origin) > 0.0 &&
        (!options.robust_table || IsTable(points, *plane, options))) {
      return plane;
    }
    rest = Peel(std::move(rest), hull);
  }
  return std::nullopt;
}

/// Section 4.2.1: the plane with the most points, whatever lies beneath it.
std::optional<Plane> DominantPlane(PointSpan points, const Vector3d& sensor_origin,
                                   const PreprocessOptions& options, base::Rng& rng) {
  Points rest(points.begin(), points.end());
  for (int i = 0; i < options.table.dominant_planes; ++i) {
    const auto fit =
        geometry::FitPlaneRansac(rest, {options.plane_draws, options.plane_distance_m}, rng);
    if (!fit || static_cast<double>(fit->inliers.size()) <
                    options.table.dominant_support * static_cast<double>(points.size())) {
      return std::nullopt;
    }
    const Plane plane = TowardsSensor(fit->plane, sensor_origin);
    if (IsUp(plane, options)) return plane;
    std::erase_if(rest, [&](const Vector3d& p) {
      return std::abs(plane.Distance(p)) <= options.plane_distance_m;
    });
  }
  return std::nullopt;
}

/// A flat cloud has no hull: all of it is the table.
std::optional<Plane> FlatCloud(PointSpan points, const Vector3d& sensor_origin,
                               const PreprocessOptions& options) {
  const double distance_m = options.plane_distance_m;
  const Points some = Thinned(points, options.table.ranking_points);
  const auto few = geometry::FitPlane(some);
  if (!few || CountNear(some, *few, distance_m) < some.size()) return std::nullopt;
  const auto plane = geometry::FitPlane(points);
  if (!plane) return std::nullopt;
  const Plane up = TowardsSensor(*plane, sensor_origin);
  const bool flat = IsUp(up, options) && CountNear(points, up, distance_m) == points.size();
  return flat ? std::optional(up) : std::nullopt;
}

/// A bound on time, not on the result: far outliers hide nearer ones in a few layers.
constexpr int kMaxPasses = 20;

/// The filter's state: the remaining points, and the distance of each from the nearest of them.
class Filter {
 public:
  Filter(PointSpan points, const KdTree& tree, const OutlierFilterOptions& options)
      : points_(points),
        tree_(tree),
        options_(options),
        kept_(points.size(), true),
        nearest_m_(geometry::NearestNeighborDistances(points, tree).each_m) {}

  /// Removes the outliers of eq. 4.5-4.9 among the remaining points; false if there was none.
  bool Pass() {
    if (points_.size() < removed_ + 2) return false;
    const CompressionRate rate = Rate();
    Indices outliers = Kept();
    std::erase_if(outliers, [&](std::uint32_t i) { return !Removes(i, rate); });
    if (outliers.empty()) return false;
    Remove(outliers);
    return true;
  }

  Indices Kept() const { return geometry::PositionsOf(kept_); }

 private:
  CompressionRate Rate() const {
    std::vector<double> kept_m;
    for (const auto i : Kept()) kept_m.push_back(nearest_m_[i]);
    const auto [min_m, max_m] = std::ranges::minmax(kept_m);
    const double sum_m = std::accumulate(kept_m.begin(), kept_m.end(), 0.0);
    return ComputeCompressionRate(min_m, max_m, sum_m / static_cast<double>(kept_m.size()));
  }

  /// The count of kept points within the radius, or `limit` if it is larger.
  std::size_t CountKept(const Vector3d& p, double radius_m, std::size_t limit) {
    const std::size_t enough = limit + removed_;
    const std::size_t count = tree_.CountWithin(p, radius_m, enough);
    if (count >= enough || removed_ == 0) return std::min(count, limit);
    tree_.Within(p, radius_m, neighbors_);
    const auto kept = std::ranges::count_if(
        neighbors_, [this](const KdTree::Neighbor& n) { return kept_[n.index]; });
    return std::min(static_cast<std::size_t>(kept), limit);
  }

  /// Counts only as far as necessary: from N_a >= N_k d_a / d_k on, a point is not isolated, and an
  /// isolated one with beta, tau <= 1 is no outlier (alpha > beta^tau >= beta).
  bool Removes(std::uint32_t i, const CompressionRate& rate) {
    if (nearest_m_[i] < options_.keep_m) return false;
    const Vector3d& p = points_[i];
    const std::size_t n_k =
        nearest_m_[i] < rate.d_k_m ? CountKept(p, rate.d_k_m, points_.size()) : 1;
    if (!options_.isolated_only) {
      return IsOutlier(rate, CountKept(p, rate.d_a_m, points_.size()), n_k, options_.unit_m);
    }
    if (rate.tau <= 1.0 && OutlierBeta(rate, n_k, options_.unit_m) <= 1.0) return false;
    const auto enough = static_cast<std::size_t>(static_cast<double>(n_k) / rate.tau) + 1;
    const std::size_t n_a = CountKept(p, rate.d_a_m, enough);
    return IsIsolated(rate, n_a, n_k) && IsOutlier(rate, n_a, n_k, options_.unit_m);
  }

  /// A point whose nearest neighbor is removed is at least as far from it as that neighbor was from
  /// its own nearest one; all other points keep their distance.
  void Remove(const Indices& outliers) {
    double min_m = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : outliers) {
      kept_[i] = false;
      min_m = std::min(min_m, nearest_m_[i]);
    }
    removed_ += outliers.size();
    for (const auto i : Kept()) {
      if (nearest_m_[i] >= min_m) nearest_m_[i] = DistanceToKept(i);
    }
  }

  double DistanceToKept(std::uint32_t i) {
    for (std::size_t k = 4;; k *= 2) {  // itself, and usually a kept one among three
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

std::optional<Table> FindTable(PointSpan points_C, const Vector3d& sensor_origin_C,
                               const PreprocessOptions& options, base::Rng& rng) {
  auto plane = FlatCloud(points_C, sensor_origin_C, options);
  if (!plane) plane = PlaneUnderAll(points_C, sensor_origin_C, options, rng);
  if (!plane && options.robust_table) {
    plane = DominantPlane(points_C, sensor_origin_C, options, rng);
  }
  return plane ? std::optional(TableOn(*plane, points_C, options)) : std::nullopt;
}

Table TableOn(const Plane& plane, PointSpan points_C, const PreprocessOptions& options) {
  return {plane, geometry::PositionsWhere(points_C, [&](const Vector3d& p) {
            return plane.Distance(p) <= options.table_clearance_m;
          })};
}

CompressionRate ComputeCompressionRate(double d_min_m, double d_max_m, double d_mean_m) {
  const double d_a_m = (d_min_m + d_max_m) / 2.0;
  return {d_a_m, d_mean_m, d_mean_m / d_a_m};
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
  if (points.size() < 2) return Indices(points.size(), 0);
  const KdTree tree(points);
  Filter filter(points, tree, options);
  const int max_passes = options.repeated ? kMaxPasses : 1;
  for (int pass = 0; pass < max_passes && filter.Pass(); ++pass) {
  }
  return filter.Kept();
}

Points Smooth(PointSpan points, double radius_m) {
  const KdTree tree(points);
  Points smoothed(points.begin(), points.end());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius_m, neighbors);
    if (neighbors.size() < 2) continue;
    // Offsets from the point itself, so that a point with no spread around it is unchanged.
    Vector3d shift = Vector3d::Zero();
    for (const KdTree::Neighbor& n : neighbors) shift += points[n.index] - points[i];
    smoothed[i] += shift / static_cast<double>(neighbors.size());
  }
  return smoothed;
}

}  // namespace rangegrasp::perception
