#pragma once

#include <string>
#include <vector>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// What a hand's file is likely to mean.
struct HandGuess {
  std::vector<int> motors;      ///< actuators that move a joint of the hand
  std::vector<int> fingertips;  ///< geoms that collide on bodies without others below them
  std::string open, closed;     ///< ends of the drives' ways, as values of a numeric
};
HandGuess GuessHand(Model& model);

/// A site "tcp" in the body "hand"; in words where pads are not known yet.
Cure SuggestTool(Model& model);

bool CheckCollides(Model& model, int fingertip);  ///< false: said that it does not

void CheckHand(Model& model);  ///< what the drives move

}  // namespace rangegrasp::check::internal
