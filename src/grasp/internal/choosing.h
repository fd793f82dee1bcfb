#pragma once

#include <vector>

#include "collision/hand_collider.h"
#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

struct Quota {
  int max_free = 24;     ///< candidates
  int max_of_group = 1;  ///< of one group
  int max_checks = 120;  ///< candidates looked at
};

/// Checks candidates in the order of their scores and appends those that are free to `accepted`;
/// the best one of every group that collides goes to `rejected`.
void ChooseFree(const collision::HandCollider& collider, const Task& task,
                std::vector<Candidate> candidates, const Quota& quota, std::vector<Grasp>& accepted,
                std::vector<Grasp>& rejected);

}  // namespace rangegrasp::grasp::internal
