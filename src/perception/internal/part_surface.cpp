#include "perception/internal/part_surface.h"

#include <utility>

namespace rangegrasp::perception::internal {

PartSurface::PartSurface(geometry::Points points_C) : points_C_(std::move(points_C)) {
  for (const auto& p : points_C_) box_.extend(p);
}

std::optional<std::uint32_t> PartSurface::NearestWithin(const Eigen::Vector3d& p_C, double gap_m) {
  if (points_C_.empty() || box_.squaredExteriorDistance(p_C) > gap_m * gap_m) return std::nullopt;
  if (!tree_) tree_.emplace(points_C_);
  tree_->Nearest(p_C, 1, nearest_);
  if (nearest_.front().squared_distance > gap_m * gap_m) return std::nullopt;
  return nearest_.front().index;
}

}  // namespace rangegrasp::perception::internal
