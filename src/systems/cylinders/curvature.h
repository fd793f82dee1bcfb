#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "geometry/kd_tree.h"
#include "geometry/normals.h"
#include "geometry/point_cloud.h"
#include "perception/sampling.h"

/// Curvature points: where a surface bends or ends (section 4.2.3).
namespace rangegrasp::cylinders {

/// cos(alpha_i) of eq. 4.13: the mean of the cosines of n_i with its m neighbors' normals, none of
/// which need be of unit length. The printed sum has no 1 / m, without which it is no cosine from
/// the second neighbor on; the mean is what one threshold of 20 deg can be held against. 1 if there
/// is no neighbor.
double MeanCosine(const Eigen::Vector3d& normal, geometry::PointSpan neighbor_normals);

/// cos(beta_i) of eq. 4.14: of the angle at p between the directions to the points before and after
/// it on its scan line: -1 on a straight line. -1, too, where two of the points are one.
double EdgeCosine(const Eigen::Vector3d& before, const Eigen::Vector3d& p,
                  const Eigen::Vector3d& after);

/// Which points face up, so that they may be of an end that is seen from above.
enum class TopGate {
  kSensorX,      ///< n_x > n_y and n_x > n_z in the sensor's frame, as published
  kTableNormal,  ///< the angle to the table's normal is below a limit
  kNone,
};
constexpr std::array<std::string_view, 3> WordsOf(TopGate) {
  return {"sensor_x", "table_normal", "none"};
}

/// n_x > n_y and n_x > n_z of a normal in the sensor's frame (section 4.2.4). Neither component's
/// size: a normal to -y passes for any n_x > 0, as printed.
inline bool PassesSensorGate(const Eigen::Vector3d& n_S) {
  return n_S.x() > n_S.y() && n_S.x() > n_S.z();
}

struct CurvatureOptions {
  /// Neighbors of a point (section 4.2.3): as far as its normal's.
  perception::AdaptiveLength radius_m{0.005, {.noises = 5.0, .spacings = 1.7}};
  double min_angle_rad = base::Deg(20.0);        ///< alpha (section 4.2.3)
  double max_edge_angle_rad = base::Deg(110.0);  ///< beta (section 4.2.3)
  /// How far before and after on the scan line the angle of an edge is looked at. 0: the adjacent
  /// samples, as published, which the dissertation's scanner has 2 mm apart. Where they are closer
  /// than the noise, every point would be an edge. Larger: rounder edges count.
  perception::AdaptiveLength line_step_m{0.002, {.noises = 8.0}};
  TopGate gate = TopGate::kTableNormal;
  /// With kTableNormal: the normal's largest component is the table's, whichever two others are
  /// taken. Larger: more of a rim's outer side.
  double max_tilt_rad = base::Deg(55.0);
};

/// For each point whether the angle of its normal to its neighbors' is above min_angle_rad
/// (eq. 4.13). O(n log n).
/// @param known  neighbors of the cloud's points as their normals' estimation found them; used if
/// they are of options.radius_m
std::vector<bool> CurvedPoints(const geometry::PointCloud& cloud, const geometry::KdTree& tree,
                               const CurvatureOptions& options,
                               const geometry::NeighborLists& known = {});

/// Where a point was measured: its scan line, and the order on it.
struct ScanPlace {
  std::uint32_t line = 0;
  std::uint32_t sample = 0;
};

/// For each point whether its scan line has an edge there (eq. 4.14). Points are in the order of
/// the scan. @param places  one a point. O(n).
/// @throws std::invalid_argument if there is not one place a point.
std::vector<bool> LineEdges(geometry::PointSpan points, std::span<const ScanPlace> places,
                            const CurvatureOptions& options);

}  // namespace rangegrasp::cylinders
