#include "collision/robot_collider.h"

#include <algorithm>

namespace rangegrasp::collision {
namespace {

const core::Pose kWorld = core::Pose::Identity();

bool HitsAny(const PlacedSolid& part, const std::vector<PlacedSolid>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const PlacedSolid& other) { return Hit(part, other); });
}

void PlaceAll(const std::vector<Solid>& solids, const core::Pose& X_WB,
              std::vector<PlacedSolid>& placed) {
  placed.clear();
  for (const Solid& solid : solids) placed.push_back(Place(solid, X_WB));
}

}  // namespace

RobotCollider::RobotCollider(const robot::Robot& robot, double margin_m)
    : robot_(robot), grown_hand_(robot.hand(), {margin_m}), bare_hand_(robot.hand(), {}) {
  for (const robot::Link& link : robot.links()) {
    std::vector<Solid>& solids = links_.emplace_back();
    for (const geometry::Shape& shape : link.shapes) {
      solids.emplace_back(shape, SolidOptions{margin_m});
    }
    const bool parent_fixed = link.parent < 0 || fixed_[static_cast<std::size_t>(link.parent)];
    fixed_.push_back(parent_fixed && link.joint < 0);
  }
  for (const geometry::Shape& shape : robot.workcell()) workcell_solids_.emplace_back(shape);
  PlaceAll(workcell_solids_, kWorld, workcell_);
}

void RobotCollider::SetScene(double table_z_m, std::span<const geometry::TriangleMesh> obstacles_W,
                             const geometry::TriangleMesh& target_W) {
  table_z_m_ = table_z_m;
  obstacle_solids_.clear();
  for (const geometry::TriangleMesh& mesh : obstacles_W) obstacle_solids_.emplace_back(mesh);
  PlaceAll(obstacle_solids_, kWorld, obstacles_);
  target_ = Solid(target_W);
}

void RobotCollider::PlaceRobot(const std::vector<core::Pose>& links_W, const core::Pose& X_WH,
                               const Contacts& contacts) {
  placed_.resize(links_.size() + 1);
  for (std::size_t i = 0; i < links_.size(); ++i) PlaceAll(links_[i], links_W[i], placed_[i]);
  const HandSolids& hand = contacts.hand_margin ? grown_hand_ : bare_hand_;
  hand.PlaceInto(X_WH, contacts.hand_state, placed_.back());
}

bool RobotCollider::IsBelowTable(const PlacedSolid& part) const {
  return part.box_W.min().z() < table_z_m_ && part.solid->LowestAt(part.X_WS) < table_z_m_;
}

bool RobotCollider::HitsTable(const Contacts& contacts) const {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (hand ? contacts.may_touch_table : fixed_[i]) continue;
    if (std::any_of(placed_[i].begin(), placed_[i].end(),
                    [&](const PlacedSolid& part) { return IsBelowTable(part); })) {
      return true;
    }
  }
  return false;
}

bool RobotCollider::HitsItself() const {
  for (const auto& [first, second] : robot_.self_pairs()) {
    for (const PlacedSolid& part : placed_[static_cast<std::size_t>(first)]) {
      if (HitsAny(part, placed_[static_cast<std::size_t>(second)])) return true;
    }
  }
  return false;
}

bool RobotCollider::HitsScene(const Contacts& contacts) const {
  const PlacedSolid target = Place(target_, kWorld);
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (!hand && fixed_[i]) continue;
    const bool with_target = contacts.target == Contacts::Target::kObstacle ||
                             (contacts.target == Contacts::Target::kHandMayTouch && !hand);
    for (const PlacedSolid& part : placed_[i]) {
      if (HitsAny(part, workcell_) || HitsAny(part, obstacles_) ||
          (with_target && Hit(part, target))) {
        return true;
      }
    }
  }
  return false;
}

/// The held object against table, work cell, obstacles and the arm (not the hand).
bool RobotCollider::HeldHits(const core::Pose& X_WH, const Contacts& contacts) const {
  if (target_.IsEmpty()) return false;
  const PlacedSolid held = Place(target_, X_WH * contacts.X_HT);
  if (!contacts.may_touch_table && IsBelowTable(held)) return true;
  if (HitsAny(held, workcell_)) return true;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    const bool ignored = !contacts.held_ignores.empty() && contacts.held_ignores[i];
    if (!ignored && Hit(held, obstacles_[i])) return true;
  }
  return std::any_of(placed_.begin(), placed_.end() - 1,
                     [&](const std::vector<PlacedSolid>& link) { return HitsAny(held, link); });
}

bool RobotCollider::Hits(const std::vector<core::Pose>& links_W, const Contacts& contacts) {
  const core::Pose X_WH = links_W.back() * robot_.X_FH;
  PlaceRobot(links_W, X_WH, contacts);
  return HitsTable(contacts) || HitsItself() || HitsScene(contacts) ||
         (contacts.target == Contacts::Target::kHeld && HeldHits(X_WH, contacts));
}

std::vector<char> RobotCollider::TouchedByTarget(const core::Pose& X_WH,
                                                 const core::Pose& X_HT) const {
  std::vector<char> touched(obstacles_.size(), 0);
  const PlacedSolid held = Place(target_, X_WH * X_HT);
  for (std::size_t i = 0; i < obstacles_.size(); ++i) touched[i] = Hit(held, obstacles_[i]);
  return touched;
}

double RobotCollider::LowestOfHand(const core::Pose& X_WH, std::size_t state) const {
  return std::min(X_WH.translation().z(), bare_hand_.LowestAt(X_WH, state));
}

}  // namespace rangegrasp::collision
