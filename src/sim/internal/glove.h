#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "sim/friction.h"
#include "sim/internal/contacts.h"

namespace rangegrasp::sim::internal {

/// The glove's friction on the target: each hand geom has the static coefficient until one of its
/// contacts slides, then the kinetic one until it sticks again.
class Glove {
 public:
  Glove(const HandGeoms& hand, const FrictionPair& pair)
      : hand_(&hand), pair_(pair), states_(hand.all().size()) {}
  void Tick(mjModel* model, const mjData* data);
  bool Slides() const { return slides_; }  ///< any fingertip that touches something

 private:
  const HandGeoms* hand_;
  FrictionPair pair_;
  std::vector<SlipState> states_;  // one for each of the hand's geoms
  bool slides_ = false;
};

}  // namespace rangegrasp::sim::internal
