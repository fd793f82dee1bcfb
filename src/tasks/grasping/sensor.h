#pragma once

#include <memory>
#include <vector>

#include "core/rng.h"
#include "geometry/observation.h"
#include "sensing/line_scanner_options.h"
#include "sensing/scan_truth.h"
#include "sim/world.h"

namespace rangegrasp::tasks::grasping {

/// What a sensor measured, and beside it what only the judge may read.
struct Sensed {
  geometry::Observation observation;
  std::vector<sensing::ScanTruth> truth;  ///< one a view, in the layout of its image
};

/// Stage 2: looks at a settled world.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual Sensed Sense(const sim::World& world, core::Rng& rng) const = 0;
};

/// The line scanner at its site. @param options  must outlive it
std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const core::Pose& X_WScanner);

}  // namespace rangegrasp::tasks::grasping
