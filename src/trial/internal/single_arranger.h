#pragma once

#include "trial/arranger.h"

namespace rangegrasp::trial::internal {

/// `arrangement: single` (MakeArranger). The arguments must outlive it.
/// @throws base::InputError if an object has no resting pose.
std::unique_ptr<Arranger> MakeSingleArranger(const Options& options, const robot::Robot& robot,
                                             const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial::internal
