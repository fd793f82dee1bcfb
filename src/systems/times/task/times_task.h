#pragma once

#include "base/rng.h"
#include "trial/trial.h"

namespace rangegrasp::times {

/// Required numbers of points of a scan.
struct ScanSize {
  int object_points = 0;  ///< of objects, above the table by more than the preselection's distance
  int table_points = 0;   ///< of the table, within the workspace
};

/// A scan of a world with these numbers of points: the scanner's lines are made denser until there
/// are enough points, and excess points are removed evenly in the order of the scan. Everything
/// else that the scanner sees (arm, floor) is removed, too.
/// @throws base::InputError if the scanner cannot see that many points.
geometry::Observation SizedScan(const trial::Cell& cell, const sim::World& world,
                                const ScanSize& size, base::Rng rng);

}  // namespace rangegrasp::times
