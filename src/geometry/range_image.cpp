#include "geometry/range_image.h"

namespace rangegrasp::geometry {

PointCloud ToCloud(const RangeImage& image, Indices* source) {
  PointCloud cloud;
  cloud.points.reserve(image.points_C.size());
  if (source != nullptr) source->clear();
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    if (!image.points_C[i].allFinite()) continue;
    cloud.points.push_back(image.points_C[i]);
    if (source != nullptr) source->push_back(static_cast<std::uint32_t>(i));
  }
  return cloud;
}

}  // namespace rangegrasp::geometry
