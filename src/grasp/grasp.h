#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/frames.h"
#include "grasp/grasp_options.h"
#include "perception/scene.h"
#include "robot/robot.h"

namespace rangegrasp::grasp {

/// kNamed: a grasp listed in the file of a known object (named_grasps.h).
enum class GraspType { kCylindrical, kRim, kPower, kNamed };
constexpr std::array<std::string_view, 4> WordsOf(GraspType) {
  return {"cylindrical", "rim", "power", "named"};
}

/// The angle [rad] between a contact's inward normal and the line to the other contact. Two
/// contacts with friction hold a body if both angles are within the friction cone (Nguyen 1988).
struct AntipodalAngles {
  double finger_rad = 0.0;
  double thumb_rad = 0.0;

  double Larger() const { return std::max(finger_rad, thumb_rad); }
};
/// Quantities found by closing the hand model on the completed object. All are zero for grasps that
/// were made in another way (on the wall of a cup, or of a known object).
struct Quality {
  AntipodalAngles angles;  ///< at the contacts found by closing the hand model
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;  ///< measured: about 12.5 deg for cylinders, 8 deg for others
  double lever_m = 0.0;         ///< offset of the centre of mass from the contacts' line, across it
  double above_m = 0.0;         ///< height of the contacts over the centre of mass; negative: below
  double drag_m = 0.0;          ///< how far the closing hand drags the object
  double slope_m = 0.0;         ///< difference in height of the two contacts
  /// Component of the surface's unit normal at each contact along the approach. If it is negative,
  /// the face leans towards the hand, and the pads slide off it.
  double finger_lean = 0.0, thumb_lean = 0.0;
  double top_margin_m = 0.0;  ///< depth of the contacts below the object's top
  double contact_m2 = 0.0;    ///< contact area: the surface within 3 mm of the pads
  double room_m = 0.0;        ///< largest gap of the hand minus the width
  double thumb_to_arm = 0.0;  ///< cosine between the closing direction and the direction to the arm
};

/// A grasp of one perceived object. Frame G is as in base/frames.h; C is the cloud's frame. With
/// centering, G's origin is midway between the expected contacts; without it, it is the hand's
/// published tool centre. Its z axis is the approach, whatever the pitch:
/// R_CH = R_CG Ry(-pitch) R_HG^T.
struct Grasp {
  GraspType type = GraspType::kPower;
  base::Pose X_CG = base::Pose::Identity();
  base::Pose X_CH = base::Pose::Identity();  ///< the hand's root body, with the pitch applied
  double pitch_rad = 0.0;  ///< rotation about y_G; positive: the thumb's tip further down
  double opening_m = 0.0;  ///< gap of the pads before closing
  double width_m = 0.0;    ///< expected gap of the pads after closing
  Quality quality{};
  double score = 0.0;                      ///< higher is better; comparable within a type only
  bool collides = false;                   ///< the open hand hits the table or anything perceived
  std::optional<double> probability = {};  ///< predicted probability of delivery (ScoreModel::Rank)
};

/// Frame G at p: the unit directions are normal to each other.
inline base::Pose GraspFrame(const Eigen::Vector3d& p, const Eigen::Vector3d& approach,
                             const Eigen::Vector3d& closing) {
  Eigen::Matrix3d R_CG;
  R_CG << closing, approach.cross(closing), approach;
  return base::MakePose(R_CG, p);
}

/// The arm that carries the hand.
struct Arm {
  /// An arm that reaches every pose.
  Arm(const Eigen::Vector3d& base) : base_C(base) {}  // NOLINT(google-explicit-constructor)
  /// The arm of a robot whose frame W is C. The robot must outlive this.
  explicit Arm(const robot::Robot& robot);

  Eigen::Vector3d base_C;
  /// Whether the arm reaches a pose of the hand within its joint limits; empty: it reaches all.
  std::function<bool(const base::Pose& X_CH)> reaches;
};

/// All candidates for one object of a scene, best first: cylindrical before rim grasps for
/// rotational objects, power grasps for others (section 5.2). Each has its collision verdict. Those
/// that the arm does not reach come after the others, and those that collide come last.
/// "Up" is the table's normal. A power grasp of a rotational object is a last resort: it is planned
/// only if no cylindrical or rim grasp is free, or if options.power_only asks for it.
/// @param arm  grasp points next to its base are preferred (section 5.2)
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
std::vector<Grasp> PlanGrasps(const perception::Scene& scene, std::size_t object,
                              const robot::HandModel& hand, const Arm& arm,
                              const GraspOptions& options,
                              std::span<const geometry::TriangleMesh> obstacles_C = {});

}  // namespace rangegrasp::grasp
