#pragma once

#include <vector>

#include "robot/collision/solid.h"
#include "robot/hand_model.h"

namespace rangegrasp::collision {

/// The shapes of a hand as solids. They are made once: from one state of the hand to the next they
/// only move. Keeps a reference to the hand.
class HandSolids {
 public:
  /// @throws std::invalid_argument if the hand has no states, or they differ in their shapes.
  HandSolids(const robot::HandModel& hand, const SolidOptions& options);

  /// All of them with the hand's root body at X_WH, in one of its states.
  std::vector<PlacedSolid> At(const base::Pose& X_WH, std::size_t state) const;
  /// The same into `placed`, whose memory is used again.
  void PlaceInto(const base::Pose& X_WH, std::size_t state, std::vector<PlacedSolid>& placed) const;
  /// The z of the hand's lowest point.
  double LowestAt(const base::Pose& X_WH, std::size_t state) const;

 private:
  const robot::HandModel* hand_;
  std::vector<Solid> solids_;
};

}  // namespace rangegrasp::collision
