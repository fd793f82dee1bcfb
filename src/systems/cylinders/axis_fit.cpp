#include "cylinders/axis_fit.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "base/quantile.h"

namespace rangegrasp::cylinders {
namespace {

/// A line that meets a plane at less than this sine has no point in it worth naming.
constexpr double kInPlane = 1e-6;

}  // namespace

geometry::Points AxisPoints(geometry::PointSpan barrel, geometry::PointSpan outward_normals,
                            double radius_m) {
  if (barrel.size() != outward_normals.size()) {
    throw std::invalid_argument("axis points need one normal a point");
  }
  geometry::Points points;
  points.reserve(barrel.size());
  for (std::size_t i = 0; i < barrel.size(); ++i) {
    points.push_back(AxisPoint(barrel[i], outward_normals[i], radius_m));
  }
  return points;
}

std::optional<Line> FitLine(geometry::PointSpan points) {
  if (points.size() < 2) return std::nullopt;
  Line line;
  line.point = geometry::Centroid(points);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d offset = p - line.point;
    covariance += offset * offset.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  if (!(solver.eigenvalues().z() > 0.0)) return std::nullopt;
  line.direction = solver.eigenvectors().col(2).normalized();
  return line;
}

std::optional<Line> FitTrimmedLine(geometry::PointSpan points, const TrimmedLineOptions& options) {
  std::optional<Line> line = FitLine(points);
  std::size_t before = points.size();
  for (int round = 0; line && round < options.rounds; ++round) {
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const Eigen::Vector3d& p : points) distances.push_back(line->Distance(p));
    const double limit_m = options.cut * base::MedianOf(distances);
    geometry::Points near;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (distances[i] <= limit_m) near.push_back(points[i]);
    }
    if (near.size() == before || near.size() < 2) break;
    before = near.size();
    if (const auto next = FitLine(near)) line = next;
  }
  return line;
}

std::optional<Eigen::Vector3d> CenterOnAxis(const Line& axis, geometry::PointSpan rim,
                                            const Eigen::Vector3d& normal) {
  const double slope = axis.direction.dot(normal);
  if (rim.empty() || std::abs(slope) < kInPlane) return std::nullopt;
  const double along = (geometry::Centroid(rim) - axis.point).dot(normal) / slope;
  return axis.point + along * axis.direction;
}

}  // namespace rangegrasp::cylinders
