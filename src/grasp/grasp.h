#pragma once

#include <vector>

#include "core/frames.h"
#include "perception/scene.h"
#include "robot/hand_model.h"

namespace rangegrasp::grasp {

enum class GraspType { kCylindrical, kRim, kPower };
/// "cylindrical", "rim" or "power".
const char* Name(GraspType type);

/// A grasp of one perceived object. Frame G as in core/frames.h; C is the cloud's frame. Its origin
/// is the hand's published tool centre without `refine`, and the middle of the expected contacts
/// with it; its z axis is the approach, whatever the pitch:
/// R_CH = R_CG Ry(-pitch) R_HG^T.
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
  /// Off: as published. Pitch 0, tool centre in the top surface's centre, moved down to contact,
  /// the tighter of both sides wins.
  /// On: candidates slide, turn, deepen and pitch, and are ranked by score.h, because a grip that
  /// is held by friction alone needs more than to enclose the object:
  ///   - pads that do not oppose each other squeeze the object out or turn it: hence other yaws,
  ///     depths below the widest section of round objects, and the narrower axis of wide ones;
  ///   - the fingers curl in and the thumb stays straight, so that level tips do not touch at one
  ///     height: hence the pitch;
  ///   - a centre of mass beside the pads' line tilts the object: hence offsets along its axis;
  ///   - one motor drives both sides and drags an object that is not midway: hence centring between
  ///     the expected contacts in place of the top surface's centre.
  bool refine = true;
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
/// "Up" is the table's normal. A power grasp of a rotational object is the last resort: it is
/// planned where neither a cylindrical nor a rim grasp is free.
/// @throws std::invalid_argument if there is no such object, or options.most < 1.
std::vector<Grasp> PlanGrasps(const perception::Scene& scene, std::size_t object,
                              const robot::HandModel& hand, const Eigen::Vector3d& arm_C,
                              const GraspOptions& options);

}  // namespace rangegrasp::grasp
