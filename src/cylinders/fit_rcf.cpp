#include "cylinders/fit_rcf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/kd_tree.h"
#include "geometry/normals.h"

namespace rangegrasp::cylinders {
namespace {

void Check(const RcfOptions& options) {
  if (options.neighborhood_m <= 0.0 || options.tolerance_m <= 0.0) {
    throw std::invalid_argument("RCF: neighborhood_m and tolerance_m must be > 0");
  }
}

// Of the cylinder on the circle, whose axis is the circle's normal: its wall's points with normals.
struct BarrelPoints {
  geometry::Points points;
  geometry::Points normals;
};

BarrelPoints BarrelOf(const FitInput& input, const RcfPreparation& prepared, const Circle& circle,
                      double tolerance_m) {
  const Barrel barrel{{circle.center, circle.normal}, circle.radius_m};
  BarrelPoints found;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (prepared.curved[i] || std::abs(barrel.Distance(input.points[i])) > tolerance_m) continue;
    // The seen end lies within the tolerance near its rim; its normals do not point to the axis.
    if (FacesUp(prepared.normals[i], input.up, input.eye - input.points[i])) continue;
    found.points.push_back(input.points[i]);
    found.normals.push_back(prepared.normals[i]);
  }
  return found;
}

}  // namespace

double MeanNormalAngle(const geometry::Points& normals, std::size_t i,
                       const std::vector<std::uint32_t>& neighbors) {
  double sum = 0.0;
  for (const std::uint32_t t : neighbors) sum += normals[i].dot(normals[t]);
  const double mean = sum / static_cast<double>(std::max<std::size_t>(neighbors.size(), 1));
  return neighbors.empty() ? 0.0 : std::acos(std::clamp(mean, -1.0, 1.0));
}

bool FacesUp(const Eigen::Vector3d& normal, const Eigen::Vector3d& up,
             const Eigen::Vector3d& to_eye) {
  const double n_x = normal.dot(up);
  const Eigen::Vector3d y = up.cross(to_eye).stableNormalized();
  return n_x > std::abs(normal.dot(y)) && n_x > std::abs(normal.dot(y.cross(up)));
}

RcfPreparation PrepareRcf(const FitInput& input, const RcfOptions& options) {
  Check(options);
  const geometry::KdTree tree(input.points);
  RcfPreparation prepared;
  prepared.normals =
      geometry::EstimateNormals(input.points, tree, options.neighborhood_m, input.eye);
  prepared.curved.assign(input.points.size(), false);
  std::vector<geometry::KdTree::Neighbor> near;
  std::vector<std::uint32_t> neighbors;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    tree.Within(input.points[i], options.neighborhood_m, near);
    neighbors.clear();
    for (const auto& neighbor : near) {
      if (neighbor.index != i) neighbors.push_back(neighbor.index);
    }
    std::sort(neighbors.begin(), neighbors.end());
    if (MeanNormalAngle(prepared.normals, i, neighbors) <= options.curvature_rad) continue;
    prepared.curved[i] = true;
    if (FacesUp(prepared.normals[i], input.up, input.eye - input.points[i])) {
      prepared.rim.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return prepared;
}

std::optional<BarrelFit> FitRcf(const FitInput& input, const RcfPreparation& prepared,
                                const RcfOptions& options, core::Rng& rng) {
  Check(options);
  const geometry::Points rim = geometry::Select(input.points, prepared.rim);
  const auto circle = FitRandomCircle(rim, options.circle, rng);
  if (!circle) return std::nullopt;
  const BarrelPoints barrel = BarrelOf(input, prepared, circle->circle, options.tolerance_m);
  const auto line = FitLine(AxisPoints(barrel.points, barrel.normals, circle->circle.radius_m));
  if (!line) return std::nullopt;
  return BarrelFit{{*line, circle->circle.radius_m}, options.circle.draws};
}

}  // namespace rangegrasp::cylinders
