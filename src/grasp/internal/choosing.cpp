#include "grasp/internal/choosing.h"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector3d;

/// How far up a candidate is tried.
std::vector<double> LiftsOf(const Task& task, const Candidate& candidate) {
  const PlacingOptions& options = task.options.placing;
  std::vector<double> lifts(options.lifts_m.begin(), options.lifts_m.end());
  if (!candidate.to_contact) return lifts;
  for (int i = 0; i < options.contact_steps; ++i) {
    lifts.push_back(lifts.back() + options.contact_step_m);
  }
  return lifts;
}

/// True if the grasp is free, as it is or a little higher (PlacingOptions::lifts_m); then its
/// opening is set.
bool IsFree(const collision::HandCollider& collider, const Task& task, Candidate& candidate) {
  const Vector3d approach = candidate.grasp.X_CG.linear().col(2);
  const Openings openings{candidate.open_state, candidate.narrow_state, candidate.held_state};
  for (const double lift : LiftsOf(task, candidate)) {
    base::Pose X_CH = candidate.grasp.X_CH;
    X_CH.translation() -= lift * approach;
    if (HitsTableClosing(collider, task.hand, X_CH, openings)) {
      if (candidate.to_contact) continue;
      return false;
    }
    if (collider.HitsObstacle(X_CH, candidate.held_state)) return false;
    const auto opening = FreeOpening(collider, X_CH, openings);
    if (!opening) continue;
    candidate.grasp.opening_m = task.hand.states[*opening].gap_m;
    candidate.grasp.X_CH = X_CH;
    candidate.grasp.X_CG.translation() -= lift * approach;
    return true;
  }
  return false;
}

}  // namespace

std::optional<std::size_t> FreeOpening(const collision::HandCollider& collider,
                                       const base::Pose& X_CH, const Openings& openings) {
  const bool one = openings.narrow == openings.wide;
  for (const std::size_t s : {openings.wide, openings.narrow}) {
    if (!collider.HitsObstacle(X_CH, s) && !collider.HitsOwn(X_CH, s)) return s;
    if (one) break;
  }
  return std::nullopt;
}

bool HitsTableClosing(const collision::HandCollider& collider, const robot::HandModel& hand,
                      const base::Pose& X_CH, const Openings& openings) {
  const std::size_t last = std::min(openings.held + 1, hand.states.size() - 1);
  for (std::size_t s = openings.wide; s <= last; ++s) {
    if (collider.HitsTable(X_CH, s)) return true;
  }
  return false;
}

void ChooseFree(const collision::HandCollider& collider, const Task& task,
                std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
                std::vector<Grasp>& rejected) {
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.grasp.score > b.grasp.score; });
  std::map<int, int> of_group;
  std::map<int, int> tried;
  int taken = 0;
  int checks = 0;
  for (Candidate& candidate : candidates) {
    if (taken >= quota.max_free || checks >= quota.max_checks) break;
    if (of_group[candidate.group] >= quota.max_of_group) continue;
    ++checks;
    if (IsFree(collider, task, candidate)) {
      ++of_group[candidate.group];
      ++taken;
      accepted.push_back(candidate.grasp);
    } else if (++tried[candidate.group] == 1) {
      candidate.grasp.collides = true;
      rejected.push_back(candidate.grasp);
    }
  }
}

}  // namespace rangegrasp::grasp::internal
