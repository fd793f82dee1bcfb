#pragma once

#include "base/rng.h"
#include "trial/trial.h"

namespace rangegrasp::times {

/// Points that a scan should have.
struct ScanSize {
  int object_points = 0;  ///< of objects, above the table by more than the preselection's distance
  int table_points = 0;   ///< of the table, within the workspace
};

/// A scan of a world with as many points as that: the scanner's lines are put closer until there
/// are enough, and those that are too many are left out evenly in the order of the scan. All else
/// that the scanner sees (arm, floor) is left out too.
/// @throws base::InputError if the scanner cannot see so many.
geometry::Observation SizedScan(const trial::Cell& cell, const sim::World& world,
                                const ScanSize& size, base::Rng rng);

}  // namespace rangegrasp::times
