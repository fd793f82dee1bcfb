#pragma once

#include <string>
#include <vector>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Probable meaning of a hand's file.
struct HandGuess {
  std::vector<int> motors;      ///< actuators that move a joint of the hand
  std::vector<int> fingertips;  ///< colliding geoms on the outermost bodies
  std::string open, closed;     ///< ends of the drives' travel, as values of a numeric
};
HandGuess GuessHand(Model& model);

/// Proposes a site "tcp" in the body "hand"; only in words if the pads are not known yet.
Cure SuggestTool(Model& model);

/// The attributes that make all equalities of a model firm; empty if they are.
Attributes FirmerEqualities(const mjModel& m);
/// The attributes that make the contacts of the first soft fingertip firm; empty if none is soft.
Attributes FirmerTips(const Model& model);

void CheckHand(Model& model);  ///< checks what its drives or its geared motor move

}  // namespace rangegrasp::check::internal
