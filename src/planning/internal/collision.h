#pragma once

#include <vector>

#include "planning/internal/solid.h"
#include "planning/planning.h"

namespace rangegrasp::planning::internal {

/// What a stage of the motion may touch.
struct Stage {
  enum class Target {
    kObstacle,      ///< not to be touched
    kHandMayTouch,  ///< between the hand's fingers: the arm must not touch it
    kHeld,          ///< in the hand
    kGone
  };
  const robot::HandModel::State* hand = nullptr;
  bool hand_margin = true;
  Target target = Target::kObstacle;
  core::Pose X_HT = core::Pose::Identity();  ///< kHeld: the frame of target_W in the hand
  std::vector<char> held_ignores;            ///< kHeld: one an obstacle
  bool may_touch_table = false;              ///< the hand and what it holds; the arm must not
  double least_upright = -1.0;  ///< the cosine of the hand's largest tilt away from up_H
  Eigen::Vector3d up_H = Eigen::Vector3d::UnitZ();
};

/// The robot, its work cell and what was perceived, for collision checks (FCL).
class CollisionModel {
 public:
  CollisionModel(const robot::Robot& robot, double margin_m);

  /// Takes a scene; stages refer to it.
  void SetScene(const PlanningScene& scene);

  /// Whether q is within the limits and touches nothing that the stage forbids.
  bool Free(const Eigen::VectorXd& q, const Stage& stage);
  /// The same for the straight joint line, at steps of resolution_rad, without its first end.
  bool EdgeFree(const Eigen::VectorXd& from, const Eigen::VectorXd& to, const Stage& stage,
                double resolution_rad);
  bool PathFree(const std::vector<Eigen::VectorXd>& path, const Stage& stage,
                double resolution_rad);

  /// One an obstacle: does the held target touch it with the hand at X_WH?
  std::vector<char> TouchedByTarget(const core::Pose& X_WH, const core::Pose& X_HT) const;
  /// The z of the hand's lowest point.
  double LowestOfHand(const core::Pose& X_WH, const robot::HandModel::State& hand);

 private:
  struct Placed {
    const Solid* solid;
    core::Pose X_WS;
    Bounds bounds;
  };
  struct HandSolids {
    const robot::HandModel::State* state;
    bool margin;
    std::vector<Solid> solids;
  };
  static Placed Place(const Solid& solid, const core::Pose& X_WB);
  static bool Hit(const Placed& a, const Placed& b);
  const std::vector<Solid>& SolidsOf(const robot::HandModel::State& state, bool margin);
  void PlaceRobot(const Eigen::VectorXd& q, const Stage& stage);
  bool HitsTable(const Stage& stage) const;
  bool HitsItself() const;
  bool HitsScene(const Stage& stage) const;
  bool HeldHits(const core::Pose& X_WH, const Stage& stage) const;

  const robot::Robot& robot_;
  double margin_m_;
  std::vector<std::vector<Solid>> links_;
  std::vector<bool> fixed_;  ///< one a link: does not move
  std::vector<HandSolids> hands_;
  std::vector<Solid> workcell_solids_;
  std::vector<Placed> workcell_;
  std::vector<Solid> obstacle_solids_;  ///< empty meshes left out
  std::vector<Placed> obstacles_;
  std::vector<Solid> target_;  ///< one, or none if its mesh is empty
  double table_z_m_ = 0.0;
  std::vector<std::vector<Placed>> placed_;  ///< links, then the hand, at the q being checked
  core::Pose X_WH_ = core::Pose::Identity();
};

}  // namespace rangegrasp::planning::internal
