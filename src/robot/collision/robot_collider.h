#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/mesh.h"
#include "robot/collision/hand_solids.h"
#include "robot/robot.h"

namespace rangegrasp::collision {

/// What the robot may touch in a stage of its motion, and what its hand looks like there.
struct Contacts {
  enum class Target {
    kObstacle,      ///< not to be touched
    kHandMayTouch,  ///< between the hand's fingers: the arm must not touch it
    kHeld,          ///< in the hand
    kGone
  };
  std::size_t hand_state = 0;  ///< of HandModel::states
  bool hand_margin = true;
  Target target = Target::kObstacle;
  base::Pose X_HT = base::Pose::Identity();  ///< kHeld: the frame of the target in the hand
  std::vector<char> held_ignores;            ///< kHeld: one an obstacle; empty: none is
  bool may_touch_table = false;              ///< the hand and what it holds; the arm must not
};

/// Two things that touch.
struct Touch {
  enum class Other { kTable, kRobot, kWorkcell, kObstacle, kTarget };
  std::size_t part = 0;  ///< position in Robot::links(); next the hand, then what it holds
  Other other = Other::kTable;
  std::size_t index = 0;  ///< kRobot: as `part`; of the work cell's shapes or the obstacles
};

/// The robot, what it holds, its work cell and what was perceived, for checks along motions. All
/// shapes are exact (SolidOptions::sides 0). Not thread-safe.
class RobotCollider {
 public:
  /// Keeps a reference to the robot.
  /// @param margin_m  grows about the arm always, about the hand where Contacts::hand_margin asks
  RobotCollider(const robot::Robot& robot, double margin_m);
  RobotCollider(const RobotCollider&) = delete;
  RobotCollider& operator=(const RobotCollider&) = delete;

  /// Takes a scene in W: the table is the plane z = table_z_m; surfaces without triangles are hit
  /// by nothing.
  void SetScene(double table_z_m, std::span<const geometry::TriangleMesh> obstacles_W,
                const geometry::TriangleMesh& target_W);

  /// Whether the robot touches something that it must not.
  /// @param links_W  robot::Robot::LinkPoses at the joint positions in question
  bool Hits(const std::vector<base::Pose>& links_W, const Contacts& contacts) {
    return FirstTouch(links_W, contacts).has_value();
  }
  /// Likewise, and what touches what: the first that is found.
  std::optional<Touch> FirstTouch(const std::vector<base::Pose>& links_W, const Contacts& contacts);
  /// The same for people: "arm/link6 and hand", "hand and the table", by the names of the MJCF.
  std::string TextOf(const Touch& touch) const;

  /// One an obstacle: does the held target touch it with the hand at X_WH?
  std::vector<char> TouchedByTarget(const base::Pose& X_WH, const base::Pose& X_HT) const;
  /// The z of the hand's lowest point, without margin.
  double LowestOfHand(const base::Pose& X_WH, std::size_t state) const;

 private:
  void PlaceRobot(const std::vector<base::Pose>& links_W, const base::Pose& X_WH,
                  const Contacts& contacts);
  bool IsBelowTable(const PlacedSolid& part) const;
  std::optional<Touch> TouchOfTable(const Contacts& contacts) const;
  std::optional<Touch> TouchOfItself() const;
  std::optional<Touch> TouchOfScene(const Contacts& contacts) const;
  std::optional<Touch> TouchOfHeld(const base::Pose& X_WH, const Contacts& contacts) const;
  std::string NameOfPart(std::size_t part) const;

  const robot::Robot& robot_;
  HandSolids grown_hand_;
  HandSolids bare_hand_;
  std::vector<std::vector<Solid>> links_;
  std::vector<bool> fixed_;  ///< one a link: does not move
  std::vector<Solid> workcell_solids_;
  std::vector<PlacedSolid> workcell_;
  std::vector<Solid> obstacle_solids_;
  std::vector<PlacedSolid> obstacles_;
  Solid target_{geometry::TriangleMesh()};
  double table_z_m_ = 0.0;
  std::vector<std::vector<PlacedSolid>> placed_;  ///< links, then the hand, as being checked
};

}  // namespace rangegrasp::collision
