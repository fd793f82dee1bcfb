#pragma once

#include "tasks/grasping/arranger.h"

namespace rangegrasp::tasks::grasping::internal {

/// `arrangement: single` (MakeArranger). The arguments must outlive it.
/// @throws core::InputError if an object has no resting pose.
std::unique_ptr<Arranger> MakeSingleArranger(const Options& options, const robot::Robot& robot,
                                             const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::tasks::grasping::internal
