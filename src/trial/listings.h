#pragma once

namespace rangegrasp::trial {

/// What `rangegrasp list` lists of grasping experiments: objects, surfaces, scenes, sensors, ...
void AddListings();

}  // namespace rangegrasp::trial
