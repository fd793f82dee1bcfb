#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/observation.h"
#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// Features of a grasp that are known before it is tried, from the observation alone: lengths in m,
/// angles in rad, shares from 0 to 1. In their names, thumb and fingers are the two sides of the
/// hand, "way" is the last part of the approach, "between" is the space between the pads, and
/// "beyond" is the space past the object's end on that side, near and far.
std::span<const std::string_view> FeatureNames();

/// Computes the features of the grasps of one object. Space is free if a sensor ray passed through
/// it, "own" or "other" if it contains measured points of the object or another thing, else unseen.
class FeatureMaker {
 public:
  /// All arguments must outlive it. It casts O(samples) rays through a grid of 6 mm, once.
  /// @param object  position in scene.objects
  FeatureMaker(const geometry::Observation& observation, const perception::Scene& scene,
               std::size_t object, const robot::HandModel& hand);
  ~FeatureMaker();

  /// One value per name.
  std::vector<double> Of(const Grasp& grasp) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::grasp
