#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/rng.h"
#include "cylinders/axis_fit.h"
#include "cylinders/circle_fit.h"
#include "cylinders/detect_options.h"
#include "cylinders/visibility.h"
#include "geometry/observation.h"
#include "perception/perceive.h"
#include "perception/scene.h"

/// Detection of given cylinders among other things on a table (section 4.2).
namespace rangegrasp::cylinders {

/// The shape of a cylinder that is looked for [m].
struct GivenCylinder {
  double radius_m = 0.0;
  double height_m = 0.0;
};

/// A fragment of curvature points whose circle passed the 80 % rule.
struct Rim {
  Circle circle_C;
  double share = 0.0;        ///< of its points on the circle (eq. 4.26)
  geometry::Indices points;  ///< positions in CylinderScene::cloud
};

/// A given cylinder that was found.
struct FoundCylinder {
  std::size_t given = 0;       ///< which
  Cylinder cylinder_C;         ///< the radius as measured, the height as given
  bool lies = false;           ///< its axis is not upright
  bool from_rim = false;       ///< found by its rim; else by its barrel
  double rim_share = 0.0;      ///< as Rim's; 0 where it was found by its barrel
  double length_seen_m = 0.0;  ///< of the barrel along the axis; 0: only its rim was seen
  ViewCounts view;             ///< how the scan agrees; zeros without check_shape
  geometry::Indices rim;       ///< positions in CylinderScene::cloud
  geometry::Indices barrel;
};

struct CylinderScene {
  geometry::Points points_C;  ///< the measured points in the workspace, in the order of the scan
  perception::Sampling sampling;  ///< zeros where lengths were not to be adapted
  perception::Table table;        ///< positions in points_C
  geometry::PointCloud cloud;     ///< points above the table after the filter, with normals
  geometry::Indices source;       ///< one a point of cloud: its position in points_C
  geometry::Indices outliers;     ///< removed by the filter; positions in points_C
  geometry::Indices curved;       ///< curvature points by normals (eq. 4.13); positions in cloud
  geometry::Indices edges;        ///< curvature points by scan lines (eq. 4.14); positions in cloud
  std::vector<geometry::Indices> fragments;  ///< of the top curvature points; positions in cloud
  std::vector<Rim> rims;
  std::vector<FoundCylinder> cylinders;  ///< in the order of the given ones
  /// Whether the cloud has the order of its scan. Without it there are no line edges.
  bool scan_order = false;
  perception::StageSeconds seconds;
};

/// F_p F_c > 0: p is on the sensor's side of the plane (eq. 4.1 to 4.4).
inline bool IsOnSensorSide(const geometry::Plane& plane, const Eigen::Vector3d& sensor_origin,
                           const Eigen::Vector3d& p) {
  return plane.Distance(p) * plane.Distance(sensor_origin) > 0.0;
}

/// Section 4.2 from what a sensor measured to the poses of given cylinders: table, filter, normals,
/// curvature points, fragments, circles, axes. An image of more than one profile has the order of
/// its scan. Cylinders that are not among the given ones are left alone.
/// @param given  at least one
/// @throws base::InputError if a given cylinder has no size, if there are fewer than 100 points, or
/// no table can be found.
/// @throws std::invalid_argument if a view has neither one origin nor one a profile.
CylinderScene DetectCylinders(const geometry::Observation& observation,
                              std::span<const GivenCylinder> given, const DetectOptions& options,
                              base::Rng& rng,
                              const std::optional<perception::Workspace>& workspace = std::nullopt);

}  // namespace rangegrasp::cylinders
