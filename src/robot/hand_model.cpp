#include "robot/hand_model.h"

namespace rangegrasp::robot {

const HandModel::State& HandModel::AtGap(double gap_m) const {
  const State* best = nullptr;
  for (const State& state : states) {
    if (state.gap_m >= gap_m && (best == nullptr || state.gap_m < best->gap_m)) best = &state;
  }
  return best ? *best : states.front();
}

}  // namespace rangegrasp::robot
