#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

struct RegistrationOptions {
  /// > 0. Pairs farther apart are left out: larger finds the way from a worse guess, smaller is
  /// less drawn by what only one cloud shows.
  double max_pair_distance_m = 0.02;
  int max_iterations = 100;  ///< >= 1; from a guess within a few pairs' distances 10 to 30 are used
  /// > 0: it has converged when an iteration moves by less; a tenth of the scanner's noise is
  /// plenty.
  double min_step_m = 1e-5;
  double min_step_rad = 1e-5;  ///< > 0, as above
};

/// A surface that many clouds are laid on, with its normals and search tree made once. Immutable; a
/// copy shares them.
class PlaneTarget {
 public:
  /// @throws std::invalid_argument unless there are 3 points or more, all finite, with a normal
  /// each.
  explicit PlaneTarget(const geometry::PointCloud& surface);

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Moves source onto target by iterated closest points, the distance taken along the target's
/// normals (Chen and Medioni 1991; IterativeClosestPointWithNormals). Single-threaded, no
/// randomness.
/// @param X_TS  the initial guess of the source's frame S in the target's frame T.
/// @return X_TS; as it was where the pairs leave the pose open.
/// @throws std::invalid_argument if an option is out of range or the source has fewer than 3 finite
///         points.
Eigen::Isometry3d RegisterPointToPlane(const Cloud& source, const PlaneTarget& target,
                                       const Eigen::Isometry3d& X_TS,
                                       const RegistrationOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
