#pragma once

#include "perception/perceive.h"

namespace rangegrasp::perception::internal {

/// The space that the sensor saw through: measured ranges by direction. A place nearer than all
/// points measured in its direction is free. A place behind a measured point, or in a direction
/// without points, is unseen. A point also counts for the cells around its own: surfaces seen at a
/// grazing angle return no points next to their silhouette.
class SensorView {
 public:
  /// @param points_C  all measured points, including the table's. O(n).
  /// @param origin_C  the sensor's position. Directions are angles about the mean direction.
  SensorView(geometry::PointSpan points_C, const Eigen::Vector3d& origin_C);

  /// Whether the sensor saw through p: every point of its cell of directions lies more than
  /// margin_m behind it.
  bool IsFree(const Eigen::Vector3d& p, double margin_m) const;

  const Eigen::Vector3d& origin_C() const { return origin_C_; }

 private:
  std::ptrdiff_t Cell(const Eigen::Vector3d& p) const;

  Eigen::Vector3d origin_C_;
  Eigen::Matrix3d axes_;        ///< columns: right, down, forward
  std::vector<float> nearest_;  ///< [m]; infinity where nothing was measured
};

/// The views from all places of the sensors, and the place from which each point of a cloud was
/// seen. Not empty. O(n) time, and 0.8 MB per place.
struct SensorViews {
  std::vector<SensorView> places;
  geometry::Indices place_of;  ///< one per point of the cloud: position in places

  /// Whether a sensor saw through p from any place.
  bool IsFree(const Eigen::Vector3d& p, double margin_m) const {
    return std::ranges::any_of(places, [&](const auto& view) { return view.IsFree(p, margin_m); });
  }
  /// Position of the sensor that measured a point of the cloud.
  const Eigen::Vector3d& OriginOf(std::uint32_t point) const {
    return places[place_of[point]].origin_C();
  }
};

/// The points that perception works on, and the places from which they were seen.
struct MeasuredPoints {
  geometry::Points points_C;      ///< view after view, each in the order of its scan
  std::vector<SampleId> samples;  ///< one per point
  /// The places of the sensors, in the order of their first point. Places closer together than half
  /// a cell of directions at 1 m count as one: they saw the same.
  geometry::Points places_C;
  geometry::Indices place_of;  ///< one per point: position in places_C
};

/// The finite samples of all views, without those outside the workspace.
/// @throws std::invalid_argument if a view has neither one origin nor one per profile.
MeasuredPoints Gather(const geometry::Observation& observation,
                      const std::optional<Workspace>& workspace);

}  // namespace rangegrasp::perception::internal
