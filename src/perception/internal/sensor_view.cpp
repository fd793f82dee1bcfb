#include "perception/internal/sensor_view.h"

#include <limits>

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;

/// Directions further from the mean one (51 deg) are not stored, and nothing there counts as free.
/// A tabletop of 1 m seen from 0.5 m away fits; twice as much would take four times the memory.
constexpr double kHalfField_rad = 0.9;
/// Size of a cell of directions: 4 mm at 1 m, two of the scanner's point distances.
constexpr double kCell_rad = 0.004;
constexpr std::ptrdiff_t kHalf = static_cast<std::ptrdiff_t>(kHalfField_rad / kCell_rad);
constexpr std::ptrdiff_t kSide = 2 * kHalf + 1;  ///< cells

/// Half of SensorView's cell of directions at the scanner's working distance of 1 m. Larger: a
/// moving sensor's free space blurs; smaller: one more grid of directions for each of its steps.
constexpr double kSamePlace_m = 0.002;

std::uint32_t PlaceOf(const Vector3d& origin_C, geometry::Points& places_C) {
  const auto known = std::ranges::find_if(
      places_C, [&](const Vector3d& place) { return (place - origin_C).norm() <= kSamePlace_m; });
  const auto position = static_cast<std::uint32_t>(known - places_C.begin());
  if (known == places_C.end()) places_C.push_back(origin_C);
  return position;
}

}  // namespace

SensorView::SensorView(geometry::PointSpan points_C, const Vector3d& origin_C)
    : origin_C_(origin_C), nearest_(kSide * kSide, std::numeric_limits<float>::infinity()) {
  Vector3d forward = Vector3d::Zero();
  for (const Vector3d& p : points_C) forward += (p - origin_C).normalized();
  if (forward.norm() < 1e-9) forward = Vector3d::UnitZ();
  axes_.col(2) = forward.normalized();
  axes_.col(0) = axes_.col(2).unitOrthogonal();
  axes_.col(1) = axes_.col(2).cross(axes_.col(0));
  for (const Vector3d& p : points_C) {
    const std::ptrdiff_t cell = Cell(p);
    if (cell < 0) continue;
    const auto range = static_cast<float>((p - origin_C_).norm());
    const std::ptrdiff_t row = cell / kSide;
    const std::ptrdiff_t column = cell % kSide;
    for (std::ptrdiff_t y = std::max(row - 1, std::ptrdiff_t{0}); y <= row + 1 && y < kSide; ++y) {
      for (std::ptrdiff_t x = std::max(column - 1, std::ptrdiff_t{0}); x <= column + 1 && x < kSide;
           ++x) {
        float& nearest = nearest_[static_cast<std::size_t>(y * kSide + x)];
        nearest = std::min(nearest, range);
      }
    }
  }
}

std::ptrdiff_t SensorView::Cell(const Vector3d& p) const {
  const Vector3d q = axes_.transpose() * (p - origin_C_);
  if (q.z() <= 0.0) return -1;
  const long column = std::lround(std::atan2(q.x(), q.z()) / kCell_rad);
  const long row = std::lround(std::atan2(q.y(), q.z()) / kCell_rad);
  if (std::abs(column) > kHalf || std::abs(row) > kHalf) return -1;
  return (row + kHalf) * kSide + column + kHalf;
}

bool SensorView::IsFree(const Vector3d& p, double margin_m) const {
  const std::ptrdiff_t cell = Cell(p);
  if (cell < 0) return false;
  const float nearest = nearest_[static_cast<std::size_t>(cell)];
  return std::isfinite(nearest) && nearest > (p - origin_C_).norm() + margin_m;
}

MeasuredPoints Gather(const geometry::Observation& observation,
                      const std::optional<Workspace>& workspace) {
  MeasuredPoints measured;
  for (std::uint32_t view = 0; view < observation.views.size(); ++view) {
    const geometry::RangeImage& image = observation.views[view].image;
    const Vector3d* origin_C = nullptr;
    std::uint32_t place = 0;
    for (std::uint32_t sample = 0; sample < image.points_C.size(); ++sample) {
      const Vector3d& p_C = image.points_C[sample];
      if (!p_C.allFinite() || (workspace && !workspace->Contains(p_C))) continue;
      const Vector3d* own = &image.OriginOf(sample);
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
