#include "robot/collision/hand_solids.h"

#include <algorithm>
#include <limits>

namespace rangegrasp::collision {

HandSolids::HandSolids(const robot::HandModel& hand, const SolidOptions& options) : hand_(&hand) {
  robot::CheckStates(hand);
  for (const geometry::Shape& shape : hand.states.front().shapes) {
    solids_.emplace_back(shape, options);
  }
}

void HandSolids::PlaceInto(const base::Pose& X_WH, std::size_t state,
                           std::vector<PlacedSolid>& placed) const {
  placed.clear();
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    placed.push_back(PlaceAt(solids_[i], X_WH * hand_->states[state].shapes[i].X_BS));
  }
}

std::vector<PlacedSolid> HandSolids::At(const base::Pose& X_WH, std::size_t state) const {
  std::vector<PlacedSolid> placed;
  PlaceInto(X_WH, state, placed);
  return placed;
}

double HandSolids::LowestAt(const base::Pose& X_WH, std::size_t state) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const PlacedSolid& part : At(X_WH, state)) {
    lowest = std::min(lowest, part.solid->LowestAt(part.X_WS));
  }
  return lowest;
}

}  // namespace rangegrasp::collision
