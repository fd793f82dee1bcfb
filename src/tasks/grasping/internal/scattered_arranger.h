#pragma once

#include "tasks/grasping/arranger.h"

namespace rangegrasp::tasks::grasping::internal {

/// `arrangement: scattered` (MakeArranger). The arguments must outlive it.
/// @throws core::InputError if an object has no resting pose, or there are too few.
std::unique_ptr<Arranger> MakeScatteredArranger(const Options& options, const robot::Robot& robot,
                                                const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::tasks::grasping::internal
