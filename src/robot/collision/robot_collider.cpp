#include "robot/collision/robot_collider.h"

#include <algorithm>

namespace rangegrasp::collision {
namespace {

const base::Pose kWorld = base::Pose::Identity();

bool HitsAny(const PlacedSolid& part, const std::vector<PlacedSolid>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const PlacedSolid& other) { return Hit(part, other); });
}

void PlaceAll(const std::vector<Solid>& solids, const base::Pose& X_WB,
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

void RobotCollider::PlaceRobot(const std::vector<base::Pose>& links_W, const base::Pose& X_WH,
                               const Contacts& contacts) {
  placed_.resize(links_.size() + 1);
  for (std::size_t i = 0; i < links_.size(); ++i) PlaceAll(links_[i], links_W[i], placed_[i]);
  const HandSolids& hand = contacts.hand_margin ? grown_hand_ : bare_hand_;
  hand.PlaceInto(X_WH, contacts.hand_state, placed_.back());
}

bool RobotCollider::IsBelowTable(const PlacedSolid& part) const {
  return part.box_W.min().z() < table_z_m_ && part.solid->LowestAt(part.X_WS) < table_z_m_;
}

std::optional<Touch> RobotCollider::TouchOfTable(const Contacts& contacts) const {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (robot_.IgnoresTable(i) || (hand ? contacts.may_touch_table : fixed_[i])) continue;
    if (std::any_of(placed_[i].begin(), placed_[i].end(),
                    [&](const PlacedSolid& part) { return IsBelowTable(part); })) {
      return Touch{i, Touch::Other::kTable};
    }
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::TouchOfItself() const {
  for (const auto& [a, b] : robot_.self_pairs()) {
    const auto first = static_cast<std::size_t>(a);
    const auto second = static_cast<std::size_t>(b);
    for (const PlacedSolid& part : placed_[first]) {
      if (HitsAny(part, placed_[second])) return Touch{first, Touch::Other::kRobot, second};
    }
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::TouchOfScene(const Contacts& contacts) const {
  const PlacedSolid target = Place(target_, kWorld);
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (!hand && fixed_[i]) continue;
    const bool with_target = contacts.target == Contacts::Target::kObstacle ||
                             (contacts.target == Contacts::Target::kHandMayTouch && !hand);
    for (const PlacedSolid& part : placed_[i]) {
      for (std::size_t k = 0; k < workcell_.size(); ++k) {
        if (!robot_.Ignores(i, k) && Hit(part, workcell_[k])) {
          return Touch{i, Touch::Other::kWorkcell, k};
        }
      }
      for (std::size_t k = 0; k < obstacles_.size(); ++k) {
        if (Hit(part, obstacles_[k])) return Touch{i, Touch::Other::kObstacle, k};
      }
      if (with_target && Hit(part, target)) return Touch{i, Touch::Other::kTarget};
    }
  }
  return std::nullopt;
}

/// The held object against table, work cell, obstacles and the arm (not the hand).
std::optional<Touch> RobotCollider::TouchOfHeld(const base::Pose& X_WH,
                                                const Contacts& contacts) const {
  if (target_.IsEmpty()) return std::nullopt;
  const std::size_t self = placed_.size();
  const PlacedSolid held = Place(target_, X_WH * contacts.X_HT);
  if (!contacts.may_touch_table && IsBelowTable(held)) return Touch{self, Touch::Other::kTable};
  for (std::size_t k = 0; k < workcell_.size(); ++k) {
    if (Hit(held, workcell_[k])) return Touch{self, Touch::Other::kWorkcell, k};
  }
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const bool ignored = !contacts.held_ignores.empty() && contacts.held_ignores[k];
    if (!ignored && Hit(held, obstacles_[k])) return Touch{self, Touch::Other::kObstacle, k};
  }
  for (std::size_t k = 0; k + 1 < placed_.size(); ++k) {
    if (HitsAny(held, placed_[k])) return Touch{self, Touch::Other::kRobot, k};
  }
  return std::nullopt;
}

std::optional<Touch> RobotCollider::FirstTouch(const std::vector<base::Pose>& links_W,
                                               const Contacts& contacts) {
  const base::Pose X_WH = links_W.back() * robot_.X_FH;
  PlaceRobot(links_W, X_WH, contacts);
  if (const auto touch = TouchOfTable(contacts)) return touch;
  if (const auto touch = TouchOfItself()) return touch;
  if (const auto touch = TouchOfScene(contacts)) return touch;
  if (contacts.target == Contacts::Target::kHeld) return TouchOfHeld(X_WH, contacts);
  return std::nullopt;
}

std::string RobotCollider::NameOfPart(std::size_t part) const {
  if (part < links_.size()) return robot_.links()[part].name;
  return part == links_.size() ? "the hand" : "the held object";
}

std::string RobotCollider::TextOf(const Touch& touch) const {
  const auto with = [&](const std::string& other) {
    return NameOfPart(touch.part) + " and " + other;
  };
  switch (touch.other) {
    case Touch::Other::kTable:
      return with("the table");
    case Touch::Other::kRobot:
      return with(NameOfPart(touch.index));
    case Touch::Other::kWorkcell:
      return with(robot_.workcell()[touch.index].name);
    case Touch::Other::kObstacle:
      return with("what was seen beside the object");
    case Touch::Other::kTarget:
      return with("the object");
  }
  return {};
}

std::vector<char> RobotCollider::TouchedByTarget(const base::Pose& X_WH,
                                                 const base::Pose& X_HT) const {
  std::vector<char> touched(obstacles_.size(), 0);
  const PlacedSolid held = Place(target_, X_WH * X_HT);
  for (std::size_t i = 0; i < obstacles_.size(); ++i) touched[i] = Hit(held, obstacles_[i]);
  return touched;
}

double RobotCollider::LowestOfHand(const base::Pose& X_WH, std::size_t state) const {
  return std::min(X_WH.translation().z(), bare_hand_.LowestAt(X_WH, state));
}

}  // namespace rangegrasp::collision
