#include "perception/internal/measured_points.h"

#include <algorithm>

namespace rangegrasp::perception::internal {
namespace {

/// Half of SensorView's cell of directions at the scanner's working distance of 1 m. Larger: a
/// moving sensor's free space blurs; smaller: one more grid of directions for every step it makes.
constexpr double kSamePlace_m = 0.002;

std::uint32_t PlaceOf(const Eigen::Vector3d& origin_C, geometry::Points& places_C) {
  const auto known = std::find_if(
      places_C.begin(), places_C.end(),
      [&](const Eigen::Vector3d& place) { return (place - origin_C).norm() <= kSamePlace_m; });
  const auto position = static_cast<std::uint32_t>(known - places_C.begin());
  if (known == places_C.end()) places_C.push_back(origin_C);
  return position;
}

}  // namespace

MeasuredPoints Gather(const geometry::Observation& observation,
                      const std::optional<Workspace>& workspace) {
  MeasuredPoints measured;
  std::size_t samples = 0;
  for (const geometry::View& view : observation.views) samples += view.image.points_C.size();
  measured.points_C.reserve(samples);
  measured.samples.reserve(samples);
  measured.place_of.reserve(samples);
  for (std::uint32_t view = 0; view < observation.views.size(); ++view) {
    const geometry::RangeImage& image = observation.views[view].image;
    const Eigen::Vector3d* origin_C = nullptr;
    std::uint32_t place = 0;
    for (std::uint32_t sample = 0; sample < image.points_C.size(); ++sample) {
      const Eigen::Vector3d& p_C = image.points_C[sample];
      if (!p_C.allFinite()) continue;
      if (workspace && !workspace->Contains(p_C)) continue;
      const Eigen::Vector3d* own = &image.OriginOf(sample);
      if (own != origin_C) place = PlaceOf(*own, measured.places_C);
      origin_C = own;
      measured.points_C.push_back(p_C);
      measured.samples.push_back({view, sample});
      measured.place_of.push_back(place);
    }
  }
  return measured;
}

}  // namespace rangegrasp::perception::internal
