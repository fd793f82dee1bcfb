#include "robot/planning/internal/motion_check.h"

#include <algorithm>
#include <cmath>

namespace rangegrasp::planning::internal {

bool EdgeFree(const std::function<bool(const Eigen::VectorXd&)>& free, const Eigen::VectorXd& from,
              const Eigen::VectorXd& to, double resolution_rad) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / resolution_rad)));
  for (int i = 1; i <= steps; ++i) {
    if (!free(from + (to - from) * (static_cast<double>(i) / steps))) return false;
  }
  return true;
}

bool MotionCheck::Free(const Eigen::VectorXd& q, const Stage& stage) {
  if ((q.array() < robot_.lower.array()).any() || (q.array() > robot_.upper.array()).any()) {
    return false;
  }
  const std::vector<base::Pose> links_W = robot_.LinkPoses(q);
  const base::Pose X_WH = links_W.back() * robot_.X_FH;
  if ((X_WH.linear() * stage.up_H).z() < stage.min_upright) return false;
  return !collider_.Hits(links_W, stage.contacts);
}

std::string MotionCheck::WhyNot(const Eigen::VectorXd& q, const Stage& stage) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (q[i] < robot_.lower[i] || q[i] > robot_.upper[i]) {
      return "joint " + std::to_string(i + 1) + " is beyond its range";
    }
  }
  const auto touch = collider_.FirstTouch(robot_.LinkPoses(q), stage.contacts);
  if (touch) return collider_.TextOf(*touch);
  return Free(q, stage) ? "" : "the hand leans too far";
}

bool MotionCheck::PathFree(const std::vector<Eigen::VectorXd>& path, const Stage& stage,
                           double resolution_rad) {
  if (path.empty() || !Free(path.front(), stage)) return false;
  const auto free = [&](const Eigen::VectorXd& q) { return Free(q, stage); };
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!EdgeFree(free, path[i - 1], path[i], resolution_rad)) return false;
  }
  return true;
}

}  // namespace rangegrasp::planning::internal
