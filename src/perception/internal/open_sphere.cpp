#include "perception/internal/open_sphere.h"

#include <algorithm>

namespace rangegrasp::perception::internal {

double OpenSphereRadius(const geometry::PointCloud& cloud, const TopSurface& top,
                        const FeatureOptions& options) {
  if (top.rim.empty()) return 0.0;
  double nearest = (cloud.points[top.rim.front()] - top.center_C).norm();
  for (const auto i : top.rim) nearest = std::min(nearest, (cloud.points[i] - top.center_C).norm());
  return options.open_sphere_factor * nearest;
}

bool IsOpen(const geometry::PointCloud& cloud, const geometry::Indices& object,
            const TopSurface& top, const FeatureOptions& options) {
  const double radius = OpenSphereRadius(cloud, top, options);
  if (radius <= 0.0) return false;
  const auto inside = std::count_if(object.begin(), object.end(), [&](auto i) {
    return (cloud.points[i] - top.center_C).norm() < radius;
  });
  const double strays =
      options.open_strays ? options.open_stray_share * static_cast<double>(top.points.size()) : 0.0;
  return static_cast<double>(inside) <= strays;
}

}  // namespace rangegrasp::perception::internal
