#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "geometry/point_cloud.h"

namespace rangegrasp::pcl_bridge {

struct RegistrationOptions {
  /// > 0. Pairs further apart are left out. A larger value converges from a worse guess; with a
  /// smaller one, points that only one cloud contains have less influence.
  double max_pair_distance_m = 0.02;
  int max_iterations = 100;  ///< >= 1; from a guess within a few pairs' distances 10 to 30 are used
  /// > 0: the registration has converged when an iteration moves by less. A tenth of the scanner's
  /// noise is small enough.
  double min_step_m = 1e-5;
  double min_step_rad = 1e-5;  ///< > 0, as above
};

/// A target surface for many registrations, with its normals and a search tree that is built once.
/// Immutable; a copy shares them.
class PlaneTarget {
 public:
  /// @throws std::invalid_argument unless there are 3 points or more, all finite and with a normal.
  explicit PlaneTarget(const geometry::PointCloud& surface);

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Registers source to target by iterative closest points, with distances along the target's
/// normals (Chen and Medioni 1991; IterativeClosestPointWithNormals). Single-threaded, no
/// randomness.
/// @param source  points that are not finite are left out.
/// @param X_TS  the initial guess of the source's frame S in the target's frame T.
/// @return X_TS; the initial guess if the pairs do not determine the pose.
/// @throws std::invalid_argument if the source has fewer than 3 finite points.
Eigen::Isometry3d RegisterPointToPlane(geometry::PointSpan source, const PlaneTarget& target,
                                       const Eigen::Isometry3d& X_TS,
                                       const RegistrationOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
