#include "grasp/handle.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/quantile.h"
#include "base/units.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

/// Unit; the direction in which points spread least.
Vector3d LeastAxis(geometry::PointSpan points, const Vector3d& mean) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
}

std::vector<double> Along(geometry::PointSpan points, const Vector3d& direction) {
  std::vector<double> along;
  for (const Vector3d& p : points) along.push_back(direction.dot(p));
  return along;
}

/// What the pads close on.
struct Bar {
  Vector3d middle_C;
  double width_m;
};

/// Where the handle is farthest out: single samples beside it do not count.
Bar OuterBar(const Handle& handle, const Vector3d& out, const Vector3d& across,
             const HandleOptions& options) {
  const double end = base::QuantileOf(Along(handle.points_C, out), 0.98);
  geometry::Points bar;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : handle.points_C) {
    if (out.dot(p) < end - options.bar_m) continue;
    bar.push_back(p);
    mean += p;
  }
  mean /= static_cast<double>(bar.size());
  const auto along = Along(bar, across);
  const double low = base::QuantileOf(along, 0.05);
  const double high = base::QuantileOf(along, 0.95);
  return {mean + (0.5 * (low + high) - across.dot(mean)) * across,
          std::max(options.min_width_m, high - low)};
}

Proposal Way(const Bar& bar, const Vector3d& approach, const Vector3d& closing, double score) {
  Eigen::Matrix3d R_CG;
  R_CG << closing, approach.cross(closing), approach;
  return {base::MakePose(R_CG, bar.middle_C), bar.width_m, approach, score};
}

}  // namespace

std::vector<Proposal> ProposeHandleGrasps(const Handle& handle, const Vector3d& up_C,
                                          const HandleOptions& options) {
  if (handle.points_C.size() < 3) return {};
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : handle.points_C) mean += p;
  mean /= static_cast<double>(handle.points_C.size());
  const Vector3d across = LeastAxis(handle.points_C, mean);
  const Vector3d from_body = mean - handle.body_C;
  const Vector3d out = (from_body - across.dot(from_body) * across).normalized();
  const Bar bar = OuterBar(handle, out, across, options);
  std::vector<Proposal> ways;
  const int steps = static_cast<int>(std::lround(base::kPi / options.step_rad));
  for (int k = -steps; k < steps; ++k) {
    const Vector3d approach = Eigen::AngleAxisd(k * options.step_rad, across) * -out;
    const double down = -approach.dot(up_C);
    // Through the body it cannot come, nor through the table.
    if (approach.dot(out) > 0.1 || down < -std::sin(options.max_rise_rad)) continue;
    for (const double sign : {1.0, -1.0}) ways.push_back(Way(bar, approach, sign * across, down));
  }
  std::ranges::stable_sort(ways, std::ranges::greater(), &Proposal::score);
  return ways;
}

}  // namespace rangegrasp::grasp
