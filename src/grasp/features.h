#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/observation.h"
#include "grasp/grasp.h"

namespace rangegrasp::grasp {

/// What is known of a grasp before it is tried, from the observation alone: lengths in m, angles in
/// rad, shares from 0 to 1. Names say what: thumb and fingers are the two sides of the hand, "way"
/// is the last part of the approach, "between" the space between the pads, "beyond" what lies past
/// the object's end on that side, nearer and further.
std::span<const std::string_view> FeatureNames();

/// Makes the features of the grasps of one object. Space is free where a ray of the sensor went
/// through it, own or another thing's where there are measured points, and otherwise unseen.
class FeatureMaker {
 public:
  /// All arguments must outlive it. O(samples) rays through a grid of 6 mm, once.
  /// @param object  position in scene.objects
  FeatureMaker(const geometry::Observation& observation, const perception::Scene& scene,
               std::size_t object, const robot::HandModel& hand);
  ~FeatureMaker();
  FeatureMaker(FeatureMaker&&) noexcept;

  /// One value a name.
  std::vector<double> Of(const Grasp& grasp) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::grasp
