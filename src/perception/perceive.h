#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/shape.h"
#include "perception/perception_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception {

/// A round part of the table. Points further than radius_m from the z axis of its frame are left
/// out (the arm, its pedestal and the table's rim are there), and so are points on or in fixtures
/// of known shape.
class Workspace {
 public:
  /// @param fixtures_C  enlarged by the measurement error
  Workspace(const base::Pose& X_CWorkspace, double radius_m,
            std::vector<geometry::Shape> fixtures_C = {})
      : X_WorkspaceC_(X_CWorkspace.inverse()),
        radius_m_(radius_m),
        fixtures_C_(std::move(fixtures_C)) {}

  /// Whether p is within the radius, at any height, and on no fixture.
  bool Contains(const Eigen::Vector3d& p_C) const {
    if ((X_WorkspaceC_ * p_C).head<2>().norm() > radius_m_) return false;
    return std::ranges::none_of(fixtures_C_, [&](const geometry::Shape& fixture_C) {
      return geometry::Inside(fixture_C, p_C);
    });
  }

 private:
  base::Pose X_WorkspaceC_;
  double radius_m_;
  std::vector<geometry::Shape> fixtures_C_;
};

/// Chapter 5.1, from sensor measurements to objects: table, filters, normals, segments, top
/// surfaces, rims, merging, completion. The samples of all views form one cloud. A normal points to
/// the place that its point was seen from, and space is free if it was seen through from any place.
/// @throws base::InputError if there are fewer than 100 points or no table plane can be found.
/// @throws std::invalid_argument if a view has neither one origin nor one per profile.
Scene Perceive(const geometry::Observation& observation, const PerceptionOptions& options,
               base::Rng& rng, const std::optional<Workspace>& workspace = std::nullopt);

/// The steps before objects are found, for methods that find them in another way: the points, their
/// sampling and the table. The cloud is all points above the table, neither filtered nor smoothed,
/// without normals.
/// @throws as Perceive
Scene PerceiveTable(const geometry::Observation& observation, const PerceptionOptions& options,
                    base::Rng& rng, const std::optional<Workspace>& workspace = std::nullopt);

/// Perceive for a plain cloud, e.g. a recorded one, seen from one place. Scene::samples are
/// positions in it.
/// @param points_C  n points [m]; those that are not finite are left out
/// @param sensor_origin_C  [m]
Scene Perceive(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
               const PerceptionOptions& options, base::Rng& rng);

/// Sets height_m, center_C, size_m and axis_C of an object that stands on the table and of which
/// completed_C is known. Without points they stay as they are. O(n log n).
void SetBox(const geometry::Plane& table, PerceivedObject& object);

}  // namespace rangegrasp::perception
