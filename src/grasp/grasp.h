#pragma once

#include <vector>

#include "core/frames.h"
#include "perception/scene.h"
#include "robot/hand_model.h"

namespace rangegrasp::grasp {

enum class GraspType { kCylindrical, kRim, kPower };

/// A grasp of one perceived object. Frame G as in core/frames.h; C is the cloud's frame.
struct Grasp {
  GraspType type = GraspType::kPower;
  core::Pose X_CG = core::Pose::Identity();
  core::Pose X_CH = core::Pose::Identity();  ///< the hand's root body, with the pitch applied
  double pitch_rad = 0.0;  ///< rotation about y_G; positive: the thumb's tip further down
  double opening_m = 0.0;  ///< gap of the pads before closing
  double width_m = 0.0;    ///< what the pads are expected to close on
  double score = 0.0;      ///< higher is better, within a type
  bool collides = false;   ///< open hand against everything perceived and the table
};

struct GraspOptions {
  /// As published: pitch 0, tool centre in the top surface's centre, moved down to contact,
  /// tightest side wins. What is added on top, each by its reason in docs/architecture.md, can be
  /// switched off.
  bool refine =
      true;  ///< slide, turn, deepen and pitch candidates to contacts that oppose each other
  double friction_cone_rad = 0.46;  ///< half angle assumed when contacts are judged (mu 0.5)
  double table_clearance_m = 0.004;
  double object_clearance_m = 0.002;
  double cylinder_pitch_rad = 0.2182;  ///< 12.5 deg
  int yaw_steps = 24;                  ///< of the cylindrical grasp round its axis
  int most = 24;                       ///< candidates returned
};

/// All candidates for one object of a scene, best first: cylindrical before rim for rotational
/// objects, power for others (section 5.2), every one with its collision verdict; those that
/// collide come last.
/// @param arm_C  the arm's base in C: grasp points next to the arm are preferred (section 5.2).
/// @param up_C   unit, away from the table.
std::vector<Grasp> PlanGrasps(const perception::Scene& scene, std::size_t object,
                              const robot::HandModel& hand, const Eigen::Vector3d& arm_C,
                              const GraspOptions& options);

}  // namespace rangegrasp::grasp
