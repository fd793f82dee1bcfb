#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "geometry/observation.h"
#include "grasp/detector.h"
#include "grasp/named_grasps.h"
#include "recognition/bring/bring_options.h"
#include "recognition/bring/understanding.h"

namespace rangegrasp::bring {

/// The known objects' grasps, by the object's name; an object without a file has none of its own.
using GraspsOf = std::map<std::string, grasp::NamedGrasps>;

/// `grasps.yaml` beside the model of each. @throws base::InputError
GraspsOf ReadGrasps(const Options& options);

/// One object of what was seen, first, with its grasps, as a detector hands them over: of a known
/// object its named grasps for the use, then those of chapter 5 on its model, of which those that
/// leave free what is to be kept free come first; of an unknown one those of chapter 5.
/// @param object  position in understanding.scene.objects
/// @param use  what it is wanted for; empty: anything
trial::Detected GraspsFor(const Understanding& understanding, std::size_t object,
                          const std::string& use, const geometry::Observation& observation,
                          const GraspsOf& grasps_of, const robot::Robot& robot,
                          const trial::Options& options);

}  // namespace rangegrasp::bring
