#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "geometry/observation.h"
#include "sensing/line_scanner_options.h"
#include "sensing/scan_truth.h"
#include "sim/world.h"

namespace rangegrasp::trial {

/// What a sensor measured, and beside it what only the judge may read.
struct Sensed {
  geometry::Observation observation;
  std::vector<sensing::ScanTruth> truth;  ///< one a view, in the layout of its image
};

/// Stage 2: looks at a settled world.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual Sensed Sense(const sim::World& world, base::Rng& rng) const = 0;
  /// Looks, and writes the cloud with all that lies between the world and it.
  /// @return what was written where, for a person; empty: there is nothing between
  virtual std::string WriteLook(const sim::World& /*world*/, base::Rng& /*rng*/,
                                const std::filesystem::path& /*cloud*/) const {
    return "";
  }
  /// What it does once before it looks, and does at its first look if it was not asked to.
  virtual void Prepare() const {}
  /// Looks at a world for nothing but that later looks at such things are faster, those of
  /// processes that are forked from this one, too.
  virtual void Rehearse(const sim::World&) const {}
  /// Whether that is of any use.
  virtual bool Rehearses() const { return false; }
};

/// The line scanner at its site. @param options  must outlive it
std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const base::Pose& X_WScanner);

}  // namespace rangegrasp::trial
