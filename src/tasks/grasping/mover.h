#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/rng.h"
#include "grasp/detection.h"
#include "planning/planning.h"
#include "robot/robot.h"
#include "tasks/grasping/options.h"

namespace rangegrasp::tasks::grasping {

/// A motion for one of the detection's grasps, or why there is none.
struct Move {
  std::optional<planning::PickPlan> plan;
  std::size_t grasp = 0;  ///< of Detection::grasps, which the plan is for
  int tried = 0;          ///< grasps that were offered to the planner
  bool blind = false;     ///< the motion passes through space that was not seen
  bool brushes = false;   ///< the object may push its neighbors while it is lifted
  std::string
      failures;  ///< "no_ik x3, approach_blocked (link5 and the hand) x2", of what was given up
};

/// Stage 4: plans the arm's motions for the first object, its best grasps first.
class Mover {
 public:
  virtual ~Mover() = default;
  /// @param q_start  where the arm stands
  virtual Move Plan(const grasp::Detection& detection, const Eigen::VectorXd& q_start,
                    core::Rng& rng) const = 0;
};

/// Inverse kinematics, straight lines and OMPL. The arguments must outlive it.
std::unique_ptr<Mover> MakeMover(const Options& options, const robot::Robot& robot);

}  // namespace rangegrasp::tasks::grasping
