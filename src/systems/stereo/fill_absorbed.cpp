#include "stereo/fill_absorbed.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/quantile.h"
#include "geometry/kd_tree.h"
#include "perception/point_filter.h"

namespace rangegrasp::perception {
namespace {

using geometry::Points;
using geometry::RangeImage;

// Unit, from the sensor; NaN where nothing was measured.
Points Directions(const RangeImage& image) {
  Points directions;
  directions.reserve(image.points_C.size());
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    directions.push_back((image.points_C[i] - image.OriginOf(i)).normalized());
  }
  return directions;
}

// The median chord of unit directions a number of samples apart; 0 if there is none.
double MedianStep(const Points& directions, std::size_t apart) {
  std::vector<double> steps;
  for (std::size_t i = 0; i + apart < directions.size(); ++i) {
    const double step = (directions[i + apart] - directions[i]).norm();
    if (std::isfinite(step)) steps.push_back(step);
  }
  return steps.empty() ? 0.0 : base::MedianOf(std::move(steps));
}

// Leaves what no ray of the laser that came back passes by.
void ForgetSeen(const geometry::View& laser, const RangeImage& stereo, double gaps,
                std::vector<bool>& kept) {
  const Points all = Directions(laser.image);
  Points returned;
  std::ranges::copy_if(all, std::back_inserter(returned),
                       [](const Eigen::Vector3d& d) { return d.allFinite(); });
  if (returned.empty()) return;
  const double reach =
      gaps * std::max(MedianStep(all, 1),
                      MedianStep(all, static_cast<std::size_t>(std::max(1, laser.image.samples))));
  const geometry::KdTree tree(returned);
  // A laser turns about its exit point, so that there is one origin for all of its rays.
  const Eigen::Vector3d origin = laser.image.OriginOf(0);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    const Eigen::Vector3d direction = (stereo.points_C[i] - origin).normalized();
    kept[i] = tree.CountWithin(direction, reach, 1) == 0;
  }
}

void ForgetOutliers(const RangeImage& stereo, const FillOptions& options, std::vector<bool>& kept) {
  geometry::Indices index;
  Points points;
  for (std::uint32_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    index.push_back(i);
    points.push_back(stereo.points_C[i]);
  }
  if (points.size() < 2) return;
  std::fill(kept.begin(), kept.end(), false);
  OutlierFilterOptions filter;
  const double spacing_m = geometry::MedianSpacing(stereo);
  filter.unit_m = std::max(filter.unit_m, options.unit_spacings * spacing_m);
  filter.keep_m = options.keep_spacings * spacing_m;
  for (const std::uint32_t k : CompressionRateFilter(points, filter)) kept[index[k]] = true;
}

}  // namespace

std::vector<bool> FillsAbsorbed(const geometry::View& laser, const geometry::View& stereo,
                                const FillOptions& options) {
  std::vector<bool> kept;
  for (const Eigen::Vector3d& p : stereo.image.points_C) kept.push_back(p.allFinite());
  ForgetSeen(laser, stereo.image, options.gaps, kept);
  ForgetOutliers(stereo.image, options, kept);
  return kept;
}

}  // namespace rangegrasp::perception
