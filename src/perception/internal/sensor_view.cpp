#include "perception/internal/sensor_view.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace rangegrasp::perception::internal {
namespace {
/// Directions further than this (51 deg) from the mean one are not kept, and nothing there counts
/// as free: a tabletop of 1 m seen from 0.5 m away fits; twice as much would take four times the
/// memory.
constexpr double kHalfField_rad = 0.9;
}  // namespace

SensorView::SensorView(geometry::PointSpan points_C, const Eigen::Vector3d& origin_C,
                       double cell_rad)
    : origin_C_(origin_C), axes_(Eigen::Matrix3d::Identity()), cell_rad_(cell_rad) {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points_C) forward += (p - origin_C).normalized();
  if (forward.norm() < 1e-9) forward = Eigen::Vector3d::UnitZ();
  axes_.col(2) = forward.normalized();
  axes_.col(0) = axes_.col(2).unitOrthogonal();
  axes_.col(1) = axes_.col(2).cross(axes_.col(0));
  half_ = static_cast<std::ptrdiff_t>(kHalfField_rad / cell_rad_);
  const auto side = static_cast<std::size_t>(2 * half_ + 1);
  nearest_.assign(side * side, std::numeric_limits<float>::infinity());
  for (const Eigen::Vector3d& p : points_C) {
    const std::ptrdiff_t cell = Cell(p);
    if (cell < 0) continue;
    const auto range = static_cast<float>((p - origin_C_).norm());
    for (std::ptrdiff_t row = -1; row <= 1; ++row) {
      for (std::ptrdiff_t column = -1; column <= 1; ++column) {
        const std::ptrdiff_t at = cell + row * (2 * half_ + 1) + column;
        if (at < 0 || at >= static_cast<std::ptrdiff_t>(nearest_.size())) continue;
        float& nearest = nearest_[static_cast<std::size_t>(at)];
        nearest = std::min(nearest, range);
      }
    }
  }
}

std::ptrdiff_t SensorView::Cell(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d q = axes_.transpose() * (p - origin_C_);
  if (q.z() <= 0.0) return -1;
  const auto column =
      static_cast<std::ptrdiff_t>(std::lround(std::atan2(q.x(), q.z()) / cell_rad_));
  const auto row = static_cast<std::ptrdiff_t>(std::lround(std::atan2(q.y(), q.z()) / cell_rad_));
  if (std::abs(column) > half_ || std::abs(row) > half_) return -1;
  return (row + half_) * (2 * half_ + 1) + column + half_;
}

bool SensorView::IsFree(const Eigen::Vector3d& p, double margin_m) const {
  const std::ptrdiff_t cell = Cell(p);
  if (cell < 0) return false;
  const float nearest = nearest_[static_cast<std::size_t>(cell)];
  return std::isfinite(nearest) && nearest > (p - origin_C_).norm() + margin_m;
}

}  // namespace rangegrasp::perception::internal
