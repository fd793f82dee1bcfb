#pragma once

#include <optional>
#include <vector>

#include "core/rng.h"
#include "perception/scene.h"

namespace rangegrasp::perception {

/// Options of sections 5.1.3 and 5.1.4.
struct FeatureOptions {
  int plane_draws = 100;
  double plane_distance_m = 0.002;
  double top_normal_angle_rad =
      0.785;  ///< a point may be of the top surface if its normal is within this of the table's
  double rim_alpha_m = 0.006;  ///< of the 2-D alpha shape
  int circle_draws = 100;
  double circle_distance_m = 0.002;        ///< eq. 5.6
  double rim_share = 0.8;                  ///< of the rim points on one circle
  double body_share = 0.8;                 ///< of the points that agree with their section
  double section_m = 0.004;                ///< thickness of the section planes along the axis
  double completion_step_rad = 0.0872665;  ///< 5 deg
  double open_sphere_factor = 2.0 / 3.0;   ///< eq. 5.9
};

/// The top surface of a segment: RANSAC plane over the points whose normals are near the table's
/// (eq. 5.5), its principal axis, extents and rim. nullopt where no point has such a normal.
std::optional<TopSurface> FindTopSurface(const geometry::PointCloud& cloud,
                                         const geometry::Indices& segment,
                                         const geometry::Plane& table,
                                         const FeatureOptions& options, core::Rng& rng);

/// A circle in the frame of the points it came from.
struct Circle {
  Eigen::Vector3d center;
  Eigen::Vector3d normal;  ///< unit; sign arbitrary
  double radius_m = 0.0;
};
/// The circle through three points (equivalent to eq. 4.18-4.21); nullopt if they are collinear.
std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);
struct CircleFit {
  Circle circle;
  geometry::Indices inliers;  ///< ascending positions in the given points
};
/// 3-D circle by RANSAC over 3-point samples, most points with | |p - c| - r | <= distance and near
/// its plane wins (eq. 5.6, 5.7), then a refit to the inliers.
std::optional<CircleFit> FitCircle(geometry::PointSpan rim, const FeatureOptions& options,
                                   core::Rng& rng);

/// Distance [m] of p from the axis through c with unit direction n: |(p - c) x n| (eq. 5.8).
double AxisDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& c, const Eigen::Vector3d& n);

/// Open or closed by a sphere in the top surface's centre of gravity with the radius of eq. 5.9:
/// open if no point is inside.
bool IsOpen(const geometry::PointCloud& cloud, const geometry::Indices& object,
            const TopSurface& top, const FeatureOptions& options);

/// Sections 5.1.3 and 5.1.4 over all segments: top surfaces, circles, merging of clipped rotational
/// parts, completion, order (topmost first).
std::vector<PerceivedObject> BuildObjects(const geometry::PointCloud& cloud,
                                          const std::vector<geometry::Indices>& segments,
                                          const geometry::Plane& table,
                                          const FeatureOptions& options, core::Rng& rng,
                                          StageSeconds& seconds);

}  // namespace rangegrasp::perception
