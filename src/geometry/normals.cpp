#include "geometry/normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace rangegrasp::geometry {
namespace {

/// Points whose spread across is less than this share of that along lie on a line, as far as their
/// plane goes: three lines of points have 0.4 and more where they are as far apart as long.
constexpr double kOnALine = 0.3;
/// By how much a neighborhood grows at a time: fewer steps overshoot, more cost time.
constexpr double kWiden = 1.4;

/// How neighbors spread round a point.
struct Spread {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of least spread; zero if there is none
  double flatness = 0.0;  ///< the middle deviation as a share of the largest; 0: on a line
};

/// Of the neighbors round p (eq. 4.10-4.12).
Spread SpreadOf(PointSpan points, const Eigen::Vector3d& p,
                const std::vector<KdTree::Neighbor>& neighbors) {
  // Sums relative to p: one pass, and small numbers.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  for (const KdTree::Neighbor& neighbor : neighbors) {
    const Eigen::Vector3d d = points[neighbor.index] - p;
    sum += d;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    xz += d.x() * d.z();
    yy += d.y() * d.y();
    yz += d.y() * d.z();
    zz += d.z() * d.z();
  }
  Eigen::Matrix3d scatter;
  scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  scatter -= sum * sum.transpose() / static_cast<double>(neighbors.size());
  const double scale = scatter.trace();
  if (!(scale > 0.0)) return {};
  // To unit size, for which the closed form is made.
  scatter /= scale;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3d& values = solver.eigenvalues();
  return {solver.eigenvectors().col(0), std::sqrt(std::max(0.0, values[1] / values[2]))};
}

/// The list of the next point, unless one before it was left out.
void Keep(const std::vector<KdTree::Neighbor>& neighbors, std::size_t i, NeighborLists& kept) {
  if (kept.ends.size() != i || kept.all.size() + neighbors.size() > kept.kMaxKept) return;
  for (const KdTree::Neighbor& neighbor : neighbors) kept.all.push_back(neighbor.index);
  kept.ends.push_back(kept.all.size());
}

}  // namespace

Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m,
                       const Eigen::Vector3d& origin) {
  return EstimateNormals(points, tree, radius_m, {&origin, 1}, Indices(points.size(), 0));
}

Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of, double max_radius_m,
                       NeighborLists* kept) {
  if (kept) *kept = {radius_m, {}, {}};
  Points normals(points.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& p = points[i];
    const Eigen::Vector3d to_origin = places[place_of[i]] - p;
    tree.Within(p, radius_m, neighbors);
    if (kept) Keep(neighbors, i, *kept);
    if (neighbors.size() < 3) tree.Nearest(p, 3, neighbors);  // a plane needs three
    Spread spread = SpreadOf(points, p, neighbors);
    for (double wider_m = kWiden * radius_m; spread.flatness < kOnALine && wider_m <= max_radius_m;
         wider_m *= kWiden) {
      tree.Within(p, wider_m, neighbors);
      spread = SpreadOf(points, p, neighbors);
    }
    Eigen::Vector3d normal = spread.normal;
    if (!(normal.squaredNorm() > 0.5)) normal = to_origin;  // 0, not 1: nothing to go by
    if (!(normal.squaredNorm() > 0.0)) normal = Eigen::Vector3d::UnitZ();
    normal.normalize();
    normals[i] = normal.dot(to_origin) < 0.0 ? Eigen::Vector3d(-normal) : normal;
  }
  return normals;
}

Points FaceNormals(PointSpan points, std::span<const std::array<std::uint32_t, 3>> triangles,
                   PointSpan places, std::span<const std::uint32_t> place_of) {
  Points normals(points.size(), Eigen::Vector3d::Zero());
  for (const auto& triangle : triangles) {
    const Eigen::Vector3d& p = points[triangle[0]];
    const Eigen::Vector3d face =
        (points[triangle[1]] - p).cross(points[triangle[2]] - p);  // of twice the area
    for (const std::uint32_t i : triangle) {
      normals[i] += face.dot(places[place_of[i]] - points[i]) < 0.0 ? Eigen::Vector3d(-face) : face;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(normals[i].squaredNorm() > 0.0)) normals[i] = places[place_of[i]] - points[i];
    if (!(normals[i].squaredNorm() > 0.0)) normals[i] = Eigen::Vector3d::UnitZ();
    normals[i].normalize();
  }
  return normals;
}

}  // namespace rangegrasp::geometry
