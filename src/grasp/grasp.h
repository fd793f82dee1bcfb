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

/// Named: of a known object, by its file (named_grasps.h).
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
/// What closing the hand model on the completed object finds; zeros for grasps that were made
/// otherwise (the wall of a cup, a known object's).
struct Quality {
  AntipodalAngles angles;  ///< of the contacts that closing the hand model finds
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;  ///< measured: about 12.5 deg for cylinders, 8 deg for others
  double lever_m = 0.0;         ///< the centre of mass beside the contacts' line, across it
  double above_m = 0.0;         ///< the contacts above the centre of mass; negative: below
  double drag_m = 0.0;          ///< of the object by the hand that closes
  double slope_m = 0.0;         ///< difference in height of the two contacts
  /// Of the surface's unit normals at the contacts along the approach: negative, the face leans
  /// towards the hand, and the pads slide off it.
  double finger_lean = 0.0, thumb_lean = 0.0;
  double top_margin_m = 0.0;  ///< of the contacts below the object's top
  double contact_m2 = 0.0;    ///< within 3 mm of the pads
  double room_m = 0.0;        ///< largest gap of the hand less the width
  double thumb_to_arm = 0.0;  ///< cosine between the closing direction and the way to the arm
};

/// A grasp of one perceived object. Frame G as in base/frames.h; C is the cloud's frame. Its origin
/// is the hand's published tool centre without centering, and the middle of the expected contacts
/// with it; its z axis is the approach, whatever the pitch:
/// R_CH = R_CG Ry(-pitch) R_HG^T.
struct Grasp {
  GraspType type = GraspType::kPower;
  base::Pose X_CG = base::Pose::Identity();
  base::Pose X_CH = base::Pose::Identity();  ///< the hand's root body, with the pitch applied
  double pitch_rad = 0.0;  ///< rotation about y_G; positive: the thumb's tip further down
  double opening_m = 0.0;  ///< gap of the pads before closing
  double width_m = 0.0;    ///< what the pads are expected to close on
  Quality quality{};
  double score = 0.0;                      ///< higher is better, within a type
  bool collides = false;                   ///< open hand against everything perceived and the table
  std::optional<double> probability = {};  ///< of delivery, by a learned score (ScoreModel::Rank)
};

/// What is known of the arm that carries the hand.
struct Arm {
  /// Of an arm that reaches everywhere.
  Arm(const Eigen::Vector3d& base) : base_C(base) {}  // NOLINT(google-explicit-constructor)
  /// Of a robot in W, which is then C. It must outlive this.
  explicit Arm(const robot::Robot& robot);

  Eigen::Vector3d base_C;
  /// Whether the joints' limits admit a pose of the hand; empty: they admit all.
  std::function<bool(const base::Pose& X_CH)> reaches;
};

/// All candidates for one object of a scene, best first: cylindrical before rim for rotational
/// objects, power for others (section 5.2), every one with its collision verdict: those that
/// the arm does not reach come after the others, and those that collide last.
/// @param arm  grasp points next to its base are preferred (section 5.2)
/// "Up" is the table's normal. A power grasp of a rotational object is the last resort: it is
/// planned where neither a cylindrical nor a rim grasp is free, or options.power_only asks for it.
/// @param obstacles_C  what the hand must not touch besides the other objects (ObstaclesOf)
/// @throws std::invalid_argument if there is no such object, or options.max_candidates < 1.
std::vector<Grasp> PlanGrasps(const perception::Scene& scene, std::size_t object,
                              const robot::HandModel& hand, const Arm& arm,
                              const GraspOptions& options,
                              std::span<const geometry::TriangleMesh> obstacles_C = {});

}  // namespace rangegrasp::grasp
