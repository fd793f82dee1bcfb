#include "geometry/plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/mesh.h"

namespace rangegrasp::geometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Three points are collinear if the sine of the angle at a corner is below this: rounding (1e-16
/// of coordinates up to 1e3 times the triangle's size) gives no larger one for an exact line.
constexpr double kCollinear = 1e-9;
/// The same for the ratio of the two larger eigenvalues, which are squares and carry rounding.
constexpr double kCollinearSquared = 1e-14;
/// Ratio of a plane's thickness to its extent: far below any sensor's noise, far above rounding.
constexpr double kFlat = 1e-9;

Indices Inliers(PointSpan points, const Plane& plane, double distance_m) {
  return PositionsWhere(
      points, [&](const Vector3d& p) { return std::abs(plane.Distance(p)) <= distance_m; });
}

std::array<std::size_t, 3> DrawThree(std::size_t n, base::Rng& rng) {
  const std::size_t a = rng.Index(n);
  std::size_t b = rng.Index(n - 1);
  if (b >= a) ++b;
  std::size_t c = rng.Index(n - 2);
  if (c >= std::min(a, b)) ++c;
  if (c >= std::max(a, b)) ++c;
  return {a, b, c};
}

/// Less Spread::flatness counts as a line: three lines of points as far apart as long have 0.4.
constexpr double kOnALine = 0.3;
/// Growth factor of a neighborhood per step: fewer steps overshoot, more steps cost time.
constexpr double kWiden = 1.4;

struct Spread {
  Vector3d normal = Vector3d::Zero();  ///< direction of least spread; zero if there is none
  double flatness = 0.0;  ///< ratio of the middle to the largest deviation; 0: on a line
};

/// The spread of the neighbors of p (eq. 4.10-4.12).
Spread SpreadOf(PointSpan points, const Vector3d& p,
                const std::vector<KdTree::Neighbor>& neighbors) {
  // Sums relative to p need only one pass and keep the numbers small.
  Vector3d sum = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
  for (const KdTree::Neighbor& neighbor : neighbors) {
    const Vector3d d = points[neighbor.index] - p;
    sum += d;
    scatter.noalias() += d * d.transpose();
  }
  scatter -= sum * sum.transpose() / static_cast<double>(neighbors.size());
  const double scale = scatter.trace();
  if (!(scale > 0.0)) return {};
  // Scaled to unit size, for which the closed form is designed.
  scatter /= scale;
  const auto [values, vectors] = base::SymmetricEigenDirect(scatter);
  return {vectors.col(0), std::sqrt(std::max(0.0, values[1] / values[2]))};
}

/// Appends the list of point i, unless the list of an earlier point was left out.
void Keep(const std::vector<KdTree::Neighbor>& neighbors, std::size_t i, NeighborLists& kept) {
  if (kept.ends.size() != i || kept.all.size() + neighbors.size() > kept.kMaxKept) return;
  for (const KdTree::Neighbor& neighbor : neighbors) kept.all.push_back(neighbor.index);
  kept.ends.push_back(kept.all.size());
}

}  // namespace

std::optional<Plane> PlaneThrough(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = b - a;
  const Vector3d v = c - a;
  const Vector3d normal = u.cross(v);
  const double length = normal.norm();
  if (!(length > kCollinear * u.norm() * v.norm())) return std::nullopt;
  return PlaneAt(normal / length, a);
}

std::optional<Plane> FitPlane(PointSpan points) {
  if (points.size() < 3) return std::nullopt;
  const Vector3d mean = Centroid(points);
  const auto [values, vectors] = base::SymmetricEigen(Scatter(points, mean));
  // Eigenvalues are squared lengths: points are collinear if their spread across is negligible.
  if (!(values[1] > kCollinearSquared * values[2]) || !(values[2] > 0.0)) return std::nullopt;
  return PlaneAt(vectors.col(0).normalized(), mean);
}

Matrix3d Scatter(PointSpan points, const Vector3d& mean) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const Vector3d& p : points) {
    const Vector3d d = p - mean;
    scatter.noalias() += d * d.transpose();
  }
  return scatter;
}

bool IsFlat(PointSpan points) {
  const auto plane = FitPlane(points);
  if (!plane) return true;
  double thickness = 0.0;
  for (const Vector3d& p : points) {
    thickness = std::max(thickness, std::abs(plane->Distance(p)));
  }
  return thickness <= kFlat * BoundsOf(points).sizes().norm();
}

std::optional<PlaneFit> FitPlaneRansac(PointSpan points, const PlaneRansacOptions& options,
                                       base::Rng& rng) {
  if (points.size() < 3) return std::nullopt;
  std::optional<Plane> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const auto [a, b, c] = DrawThree(points.size(), rng);
    const auto plane = PlaneThrough(points[a], points[b], points[c]);
    if (!plane) continue;
    const std::size_t count = base::CountToBeat(points, best_count, [&](const Vector3d& p) {
      return std::abs(plane->Distance(p)) <= options.inlier_distance_m;
    });
    if (count > best_count) {
      best = plane;
      best_count = count;
    }
  }
  if (!best) return std::nullopt;
  const Indices inliers = Inliers(points, *best, options.inlier_distance_m);
  const Plane plane = FitPlane(Select(points, inliers)).value_or(*best);
  return PlaneFit{plane, Inliers(points, plane, options.inlier_distance_m)};
}

Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of, double max_radius_m,
                       NeighborLists* kept) {
  if (kept) *kept = {radius_m, {}, {}};
  Points normals(points.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d& p = points[i];
    const Vector3d to_origin = places[place_of.empty() ? 0 : place_of[i]] - p;
    tree.Within(p, radius_m, neighbors);
    if (kept) Keep(neighbors, i, *kept);
    if (neighbors.size() < 3) tree.Nearest(p, 3, neighbors);  // a plane needs three
    Spread spread = SpreadOf(points, p, neighbors);
    for (double wider_m = kWiden * radius_m; spread.flatness < kOnALine && wider_m <= max_radius_m;
         wider_m *= kWiden) {
      tree.Within(p, wider_m, neighbors);
      spread = SpreadOf(points, p, neighbors);
    }
    Vector3d normal = spread.normal;
    if (!(normal.squaredNorm() > 0.5)) normal = to_origin;  // zero, not unit: unknown
    if (!(normal.squaredNorm() > 0.0)) normal = Vector3d::UnitZ();
    normal.normalize();
    normals[i] = normal.dot(to_origin) < 0.0 ? Vector3d(-normal) : normal;
  }
  return normals;
}

Points FaceNormals(PointSpan points, std::span<const std::array<std::uint32_t, 3>> triangles,
                   PointSpan places, std::span<const std::uint32_t> place_of) {
  Points normals(points.size(), Vector3d::Zero());
  for (const auto& triangle : triangles) {
    const Vector3d& p = points[triangle[0]];
    const Vector3d face =
        (points[triangle[1]] - p).cross(points[triangle[2]] - p);  // its length is twice the area
    for (const std::uint32_t i : triangle) {
      normals[i] += face.dot(places[place_of[i]] - points[i]) < 0.0 ? Vector3d(-face) : face;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(normals[i].squaredNorm() > 0.0)) normals[i] = places[place_of[i]] - points[i];
    if (!(normals[i].squaredNorm() > 0.0)) normals[i] = Vector3d::UnitZ();
    normals[i].normalize();
  }
  return normals;
}

}  // namespace rangegrasp::geometry
