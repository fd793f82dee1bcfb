#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"

namespace rangegrasp::planning::internal {

/// A path search in joint space.
struct JointQuery {
  Eigen::VectorXd start, goal;
  std::function<bool(const Eigen::VectorXd&)> free;
  /// Moves a uniform sample to where paths are worth looking for; may be empty.
  std::function<void(Eigen::VectorXd&)> project;
  double resolution_rad = 0.04;
  int iterations = 1500;
  double seconds = 2.0;  ///< wall time
};

/// Waypoints from start to goal, start and goal among them: the straight line where it is free,
/// else RRTConnect (Kuffner and LaValle 2000, from OMPL) with shortcuts. All random draws come from
/// rng. nullopt if none was found.
std::optional<std::vector<Eigen::VectorXd>> PlanJointPath(const robot::Robot& robot,
                                                          const JointQuery& query, base::Rng& rng);

}  // namespace rangegrasp::planning::internal
