#include "planning/internal/collision.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::planning::internal {

CollisionModel::CollisionModel(const robot::Robot& robot, double margin_m)
    : robot_(robot), margin_m_(margin_m) {
  for (const robot::Link& link : robot.links()) {
    std::vector<Solid>& solids = links_.emplace_back();
    for (const geometry::Shape& shape : link.shapes) solids.emplace_back(shape, margin_m);
    const bool parent_fixed = link.parent < 0 || fixed_[static_cast<std::size_t>(link.parent)];
    fixed_.push_back(parent_fixed && link.joint < 0);
  }
  for (const geometry::Shape& shape : robot.workcell()) workcell_solids_.emplace_back(shape, 0.0);
  for (const Solid& solid : workcell_solids_) {
    workcell_.push_back(Place(solid, core::Pose::Identity()));
  }
}

void CollisionModel::SetScene(const PlanningScene& scene) {
  table_z_m_ = scene.table_z_m;
  obstacles_.clear();
  obstacle_solids_.clear();
  target_.clear();
  for (const geometry::TriangleMesh& mesh : scene.obstacles_W) {
    if (!mesh.triangles.empty()) obstacle_solids_.emplace_back(mesh);
  }
  for (const Solid& solid : obstacle_solids_) {
    obstacles_.push_back(Place(solid, core::Pose::Identity()));
  }
  if (!scene.target_W.triangles.empty()) target_.emplace_back(scene.target_W);
}

CollisionModel::Placed CollisionModel::Place(const Solid& solid, const core::Pose& X_WB) {
  const core::Pose X_WS = X_WB * solid.X_BS();
  return {&solid, X_WS, solid.BoundsAt(X_WS)};
}

bool CollisionModel::Hit(const Placed& a, const Placed& b) {
  return a.bounds.Overlaps(b.bounds) && a.solid->Hits(a.X_WS, *b.solid, b.X_WS);
}

const std::vector<Solid>& CollisionModel::SolidsOf(const robot::HandModel::State& state,
                                                   bool margin) {
  for (const HandSolids& known : hands_) {
    if (known.state == &state && known.margin == margin) return known.solids;
  }
  HandSolids hand{&state, margin, {}};
  for (const geometry::Shape& shape : state.shapes) {
    hand.solids.emplace_back(shape, margin ? margin_m_ : 0.0);
  }
  hands_.push_back(std::move(hand));
  return hands_.back().solids;
}

void CollisionModel::PlaceRobot(const Eigen::VectorXd& q, const Stage& stage) {
  const std::vector<core::Pose> poses_W = robot_.LinkPoses(q);
  placed_.resize(links_.size() + 1);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    placed_[i].clear();
    for (const Solid& solid : links_[i]) placed_[i].push_back(Place(solid, poses_W[i]));
  }
  X_WH_ = poses_W.back() * robot_.X_FH;
  placed_.back().clear();
  for (const Solid& solid : SolidsOf(*stage.hand, stage.hand_margin)) {
    placed_.back().push_back(Place(solid, X_WH_));
  }
}

bool CollisionModel::HitsTable(const Stage& stage) const {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (hand ? stage.may_touch_table : fixed_[i]) continue;
    for (const Placed& part : placed_[i]) {
      if (part.bounds.low.z() < table_z_m_ && part.solid->LowestAt(part.X_WS) < table_z_m_) {
        return true;
      }
    }
  }
  return false;
}

bool CollisionModel::HitsItself() const {
  for (const auto& [first, second] : robot_.self_pairs()) {
    for (const Placed& a : placed_[static_cast<std::size_t>(first)]) {
      for (const Placed& b : placed_[static_cast<std::size_t>(second)]) {
        if (Hit(a, b)) return true;
      }
    }
  }
  return false;
}

bool CollisionModel::HitsScene(const Stage& stage) const {
  std::vector<Placed> target;
  for (const Solid& solid : target_) target.push_back(Place(solid, core::Pose::Identity()));
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool hand = i == fixed_.size();
    if (!hand && fixed_[i]) continue;
    const bool with_target = stage.target == Stage::Target::kObstacle ||
                             (stage.target == Stage::Target::kHandMayTouch && !hand);
    for (const Placed& part : placed_[i]) {
      const auto hit = [&](const Placed& other) { return Hit(part, other); };
      if (std::any_of(workcell_.begin(), workcell_.end(), hit) ||
          std::any_of(obstacles_.begin(), obstacles_.end(), hit) ||
          (with_target && std::any_of(target.begin(), target.end(), hit))) {
        return true;
      }
    }
  }
  return false;
}

/// The held object against table, work cell, obstacles and the arm (not the hand).
bool CollisionModel::HeldHits(const core::Pose& X_WH, const Stage& stage) const {
  if (target_.empty()) return false;
  const Placed held = Place(target_.front(), X_WH * stage.X_HT);
  if (!stage.may_touch_table && held.bounds.low.z() < table_z_m_ &&
      held.solid->LowestAt(held.X_WS) < table_z_m_) {
    return true;
  }
  const auto hit = [&](const Placed& other) { return Hit(held, other); };
  if (std::any_of(workcell_.begin(), workcell_.end(), hit)) return true;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    if (!stage.held_ignores[i] && hit(obstacles_[i])) return true;
  }
  return std::any_of(placed_.begin(), placed_.end() - 1, [&](const std::vector<Placed>& link) {
    return std::any_of(link.begin(), link.end(), hit);
  });
}

bool CollisionModel::Free(const Eigen::VectorXd& q, const Stage& stage) {
  if ((q.array() < robot_.lower.array()).any() || (q.array() > robot_.upper.array()).any()) {
    return false;
  }
  PlaceRobot(q, stage);
  if ((X_WH_.linear() * stage.up_H).z() < stage.least_upright) return false;
  return !HitsTable(stage) && !HitsItself() && !HitsScene(stage) &&
         (stage.target != Stage::Target::kHeld || !HeldHits(X_WH_, stage));
}

bool CollisionModel::EdgeFree(const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                              const Stage& stage, double resolution_rad) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / resolution_rad)));
  for (int i = 1; i <= steps; ++i) {
    if (!Free(from + (to - from) * (static_cast<double>(i) / steps), stage)) return false;
  }
  return true;
}

bool CollisionModel::PathFree(const std::vector<Eigen::VectorXd>& path, const Stage& stage,
                              double resolution_rad) {
  if (path.empty() || !Free(path.front(), stage)) return false;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!EdgeFree(path[i - 1], path[i], stage, resolution_rad)) return false;
  }
  return true;
}

std::vector<char> CollisionModel::TouchedByTarget(const core::Pose& X_WH,
                                                  const core::Pose& X_HT) const {
  std::vector<char> touched(obstacles_.size(), 0);
  if (target_.empty()) return touched;
  const Placed held = Place(target_.front(), X_WH * X_HT);
  for (std::size_t i = 0; i < obstacles_.size(); ++i) touched[i] = Hit(held, obstacles_[i]);
  return touched;
}

double CollisionModel::LowestOfHand(const core::Pose& X_WH, const robot::HandModel::State& hand) {
  double lowest = X_WH.translation().z();
  for (const Solid& solid : SolidsOf(hand, false)) {
    lowest = std::min(lowest, solid.LowestAt(X_WH * solid.X_BS()));
  }
  return lowest;
}

}  // namespace rangegrasp::planning::internal
