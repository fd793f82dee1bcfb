#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "grasp/internal/placing.h"
#include "robot/collision/hand_collider.h"

namespace rangegrasp::grasp::internal {

struct Quota {
  int max_free = 24;     ///< candidates
  int max_of_group = 1;  ///< of one group
  int max_checks = 120;  ///< candidates looked at
};

/// States of the hand: how it may be open before it closes, and what it is expected to hold at.
struct Openings {
  std::size_t wide = 0;
  std::size_t narrow = 0;
  std::size_t held = 0;
};

/// The wide opening, then the narrow one, that clears obstacles and the object itself.
std::optional<std::size_t> FreeOpening(const collision::HandCollider& collider,
                                       const base::Pose& X_CH, const Openings& openings);
/// Whether the hand meets the table at an opening from the wide one to the one just beyond the
/// held.
bool HitsTableClosing(const collision::HandCollider& collider, const robot::HandModel& hand,
                      const base::Pose& X_CH, const Openings& openings);

/// Checks candidates in the order of their scores and appends those that are free to `accepted`;
/// the best one of every group that collides goes to `rejected`.
void ChooseFree(const collision::HandCollider& collider, const Task& task,
                std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
                std::vector<Grasp>& rejected);

}  // namespace rangegrasp::grasp::internal
