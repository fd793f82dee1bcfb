#include "robot/hand_model.h"

#include <stdexcept>

namespace rangegrasp::robot {

std::size_t HandModel::IndexAtGap(double gap_m) const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (states[i].gap_m >= gap_m && states[i].gap_m < states[best].gap_m) best = i;
  }
  return best;
}

void CheckStates(const HandModel& hand) {
  if (hand.states.empty()) throw std::invalid_argument("hand model: no states");
  const std::size_t shapes = hand.states.front().shapes.size();
  for (const HandModel::State& state : hand.states) {
    if (state.shapes.size() != shapes || state.is_finger.size() != shapes ||
        state.is_thumb.size() != shapes) {
      throw std::invalid_argument("hand model: states differ in their shapes");
    }
  }
}

}  // namespace rangegrasp::robot
