#include "geometry/range_image.h"

#include <fmt/format.h>

#include <stdexcept>
#include <vector>

#include "base/quantile.h"

namespace rangegrasp::geometry {

const Eigen::Vector3d& RangeImage::OriginOf(std::size_t index) const {
  if (origins_C.size() == 1) return origins_C.front();
  if (samples < 1 || origins_C.size() != static_cast<std::size_t>(profiles)) {
    throw std::invalid_argument(
        fmt::format("RangeImage: {} origins for {} profiles; one is needed, or one a profile",
                    origins_C.size(), profiles));
  }
  return origins_C[index / static_cast<std::size_t>(samples)];
}

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

double MedianSpacing(const RangeImage& image) {
  std::vector<double> distances;
  for (int profile = 0; profile < image.profiles; ++profile) {
    for (int sample = 0; sample < image.samples; ++sample) {
      const Eigen::Vector3d& point = image.points_C[image.Index(profile, sample)];
      double sum = 0.0;
      int neighbors = 0;
      const auto take = [&](const Eigen::Vector3d& neighbor) {
        const double distance = (neighbor - point).norm();  // NaN where one was not measured
        if (!(distance >= 0.0)) return;
        sum += distance;
        ++neighbors;
      };
      if (sample + 1 < image.samples) take(image.points_C[image.Index(profile, sample + 1)]);
      if (profile + 1 < image.profiles) take(image.points_C[image.Index(profile + 1, sample)]);
      if (neighbors > 0) distances.push_back(sum / neighbors);
    }
  }
  return distances.empty() ? 0.0 : base::MedianOf(std::move(distances));
}

}  // namespace rangegrasp::geometry
