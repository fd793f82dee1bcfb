#pragma once

#include "trial/arranger.h"

namespace rangegrasp::trial::internal {

/// `arrangement: scattered` (MakeArranger). The arguments must outlive it.
/// @throws base::InputError if an object has no resting pose, or there are too few.
std::unique_ptr<Arranger> MakeScatteredArranger(const Options& options, const robot::Robot& robot,
                                                const sensing::LineScannerOptions& scanner);

}  // namespace rangegrasp::trial::internal
