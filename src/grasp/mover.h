#pragma once

#include "grasp/detector.h"
#include "robot/planning/planning.h"

namespace rangegrasp::grasp {

/// A motion for one of the detection's grasps, or the reason why there is none.
struct Move {
  std::optional<planning::PickPlan> plan;
  std::size_t grasp = 0;  ///< position in Detection::grasps of the planned grasp
  int tried = 0;          ///< grasps that were offered to the planner
  bool blind = false;     ///< the motion passes through space that was not seen
  bool brushes = false;   ///< the object may push its neighbors while it is lifted
  /// Reasons why grasps were given up, most frequent first: "no_ik x3, approach_blocked (link5 and
  /// the hand) x2"
  std::string failures;
};

/// Extensions of motion planning beyond the dissertation, whose planner gets the grasps in their
/// order and keeps clear of everything (section 4.3). All off: one pass over the grasps.
struct MoverAdditions {
  bool sound_first = true;     ///< a grasp that is expected to hold is worth a bolder motion
  bool through_unseen = true;  ///< it may be empty, and the approach stops at contact
  bool brushing = true;        ///< neighbors may give way
};
constexpr std::array<base::Addition<MoverAdditions>, 3> AdditionsOf(const MoverAdditions*) {
  using A = MoverAdditions;
  return {{
      {"sound_first", &A::sound_first,
       "try grasps whose contacts are within the friction cone with all motions before the others"},
      {"through_unseen", &A::through_unseen,
       "if no motion avoids unseen space, allow one through it"},
      {"brushing", &A::brushing,
       "if no motion avoids the neighbors, allow the lifted object to push them"},
  }};
}
static_assert(base::AllAdditionsListed<MoverAdditions>());

/// The switches of its base class are the extensions beyond the dissertation.
struct MoverOptions : MoverAdditions {
  planning::PlanOptions planning;
  int max_plans = 24;  ///< grasps that are offered to the planner before the trial is given up
};

/// Stage 4: plans the arm's motions for the first object and tries its best grasps first. Inverse
/// kinematics, straight lines and OMPL.
/// @param friction_cone_rad  contacts with a smaller angle hold (GraspOptions)
/// @param q_start  current joint positions of the arm
Move PlanMove(const Detection& detection, const Eigen::VectorXd& q_start,
              const MoverOptions& options, double friction_cone_rad, const robot::Robot& robot,
              base::Rng& rng);

/// Reads all keys of the mapping `planning`: those of the mover, and those of its obstacles.
/// @throws base::InputError
void ReadPlanningOptions(base::YamlMap map, MoverOptions& options, ObstacleOptions& obstacles);

}  // namespace rangegrasp::grasp
