#include "grasp/rim.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "geometry/kd_tree.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

/// A quadric has six coefficients.
constexpr Eigen::Index kMinNeighbors = 6;
/// [m^2] points on a line have no second principal axis: less than this in it is rounding.
constexpr double kMinSpread_m2 = 1e-12;

double WrappedAngle(double a) { return std::remainder(a, 2.0 * base::kPi); }

}  // namespace

std::optional<double> GaussianCurvature(geometry::PointSpan neighbors, const Vector3d& center) {
  const auto n = static_cast<Eigen::Index>(neighbors.size());
  if (n < kMinNeighbors) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : neighbors) mean += p / static_cast<double>(n);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : neighbors) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  if (axes.eigenvalues()[1] < kMinSpread_m2) return std::nullopt;
  Eigen::MatrixXd A(n, 6);
  Eigen::VectorXd h(n);
  // Lengths in units of the neighbourhood, so that the columns weigh alike.
  const double unit = std::sqrt(axes.eigenvalues()[2] / static_cast<double>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d q =
        axes.eigenvectors().transpose() * (neighbors[static_cast<std::size_t>(i)] - center) / unit;
    const double u = q[1];
    const double v = q[2];
    A.row(i) << u * u, u * v, v * v, u, v, 1.0;
    h[i] = q[0];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < kMinNeighbors) return std::nullopt;
  const Eigen::VectorXd x = qr.solve(h);
  const double slope = 1.0 + x[3] * x[3] + x[4] * x[4];
  return (4.0 * x[0] * x[2] - x[1] * x[1]) / (slope * slope) / (unit * unit);
}

std::vector<double> SmoothAround(std::span<const double> angles_rad, std::span<const double> values,
                                 double sigma_rad) {
  std::vector<double> smooth(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    double sum = 0.0;
    double weights = 0.0;
    for (std::size_t j = 0; j < values.size(); ++j) {
      const double d = WrappedAngle(angles_rad[i] - angles_rad[j]) / sigma_rad;
      const double weight = std::exp(-0.5 * d * d);
      sum += weight * values[j];
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  return smooth;
}

namespace {

/// A point in cylindrical coordinates about the rotation axis.
struct Polar {
  double angle_rad, radius_m, height_m;
};

class Cylindrical {
 public:
  Cylindrical(const perception::RotationAxis& axis, const Vector3d& axis_C, const Vector3d& zero_C)
      : center_(axis.center_C), axis_(axis_C), u_(zero_C), v_(axis_C.cross(zero_C)) {}
  Polar operator()(const Vector3d& p) const {
    const Vector3d d = p - center_;
    return {std::atan2(d.dot(v_), d.dot(u_)), (d - d.dot(axis_) * axis_).norm(), d.dot(axis_)};
  }

 private:
  Vector3d center_, axis_, u_, v_;
};

/// |K| at the rim's points, by sector: the mean of those that fall into it.
std::vector<double> RimCurvature(const perception::Scene& scene,
                                 const perception::PerceivedObject& object,
                                 const Cylindrical& polar, std::size_t sectors,
                                 double neighborhood_m) {
  std::vector<double> sum(sectors, 0.0);
  std::vector<double> count(sectors, 0.0);
  if (!object.top || object.points.size() < kMinNeighbors) return sum;
  const geometry::Points points = geometry::Select(scene.cloud.points, object.points);
  const geometry::KdTree tree(points);
  std::vector<geometry::KdTree::Neighbor> found;
  geometry::Points neighbors;
  for (const std::uint32_t i : object.top->rim) {
    const Vector3d& p = scene.cloud.points[i];
    tree.Within(p, neighborhood_m, found);
    neighbors.clear();
    for (const auto& neighbor : found) neighbors.push_back(points[neighbor.index]);
    const auto curvature = GaussianCurvature(neighbors, p);
    if (!curvature) continue;
    const double turn = polar(p).angle_rad / (2.0 * base::kPi);
    const auto k = static_cast<std::size_t>(
                       std::lround((turn - std::floor(turn)) * static_cast<double>(sectors))) %
                   sectors;
    sum[k] += std::abs(*curvature);
    count[k] += 1.0;
  }
  for (std::size_t k = 0; k < sectors; ++k) sum[k] /= std::max(1.0, count[k]);
  return sum;
}

/// The points of the wall a little below the rim.
std::vector<Polar> WallPoints(geometry::PointSpan points, const Cylindrical& polar,
                              double rim_radius_m, const RimOptions& options) {
  std::vector<Polar> wall;
  for (const Vector3d& p : points) {
    const Polar q = polar(p);
    if (q.height_m > options.above_rim_m || q.height_m < -options.below_rim_m) continue;
    if (std::abs(q.radius_m - rim_radius_m) <= options.max_wall_m) wall.push_back(q);
  }
  return wall;
}

/// Inner and outer radius of the wall near an angle.
void MeasureWall(const std::vector<Polar>& wall, double rim_radius_m, const RimOptions& options,
                 RimSector& sector) {
  double inner = std::numeric_limits<double>::infinity();
  double outer = 0.0;
  for (const Polar& p : wall) {
    const double apart = std::abs(p.angle_rad - sector.angle_rad);
    if (std::min(apart, std::abs(2.0 * base::kPi - apart)) > options.sector_rad) continue;
    inner = std::min(inner, p.radius_m);
    outer = std::max(outer, p.radius_m);
  }
  const bool seen = outer > inner + options.min_wall_m;
  sector.wall_m = seen ? outer - inner : options.assumed_wall_m;
  sector.radius_m = seen ? 0.5 * (outer + inner) : rim_radius_m - 0.5 * options.assumed_wall_m;
}

}  // namespace

std::vector<RimSector> DescribeRim(const perception::Scene& scene,
                                   const perception::PerceivedObject& object,
                                   const Vector3d& axis_C, const Vector3d& zero_C, int sectors,
                                   const RimOptions& options) {
  const Cylindrical polar(*object.axis, axis_C, zero_C);
  const auto n = static_cast<std::size_t>(sectors);
  const auto wall = WallPoints(object.completed_C, polar, object.axis->radius_m, options);
  std::vector<RimSector> rim(n);
  std::vector<double> angles(n);
  for (std::size_t k = 0; k < n; ++k) {
    angles[k] = 2.0 * base::kPi * static_cast<double>(k) / static_cast<double>(sectors);
    rim[k].angle_rad = angles[k];
    MeasureWall(wall, object.axis->radius_m, options, rim[k]);
  }
  const std::vector<double> curvature = SmoothAround(
      angles, RimCurvature(scene, object, polar, n, options.neighborhood_m), options.smooth_rad);
  const double max = *std::max_element(curvature.begin(), curvature.end());
  if (max <= 0.0) return rim;
  for (std::size_t k = 0; k < n; ++k) rim[k].curvature = curvature[k] / max;
  return rim;
}

}  // namespace rangegrasp::grasp
