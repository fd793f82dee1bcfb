#pragma once

#include "trial/arranger.h"

namespace rangegrasp::trial::internal {

/// `arrangement: touching`, `box` and `pile` (MakeArranger). The arguments must outlive it.
/// @throws base::InputError if there are too few objects, or no box in the scene.
std::unique_ptr<Arranger> MakeClutterArranger(const Options& options, const robot::Robot& robot,
                                              const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial::internal
