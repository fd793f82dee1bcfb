#pragma once

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

/// The features of the grasps of one object, one value per name. Space is free if a sensor ray
/// passed through it, "own" or "other" if it contains measured points of the object or another
/// thing, else unseen. O(samples) rays are cast through a grid of 6 mm, once.
/// @param object  position in scene.objects
std::vector<std::vector<double>> FeaturesOf(const geometry::Observation& observation,
                                            const perception::Scene& scene, std::size_t object,
                                            const robot::HandModel& hand,
                                            std::span<const Grasp> grasps);

}  // namespace rangegrasp::grasp
