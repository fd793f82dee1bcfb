#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "geometry/cloud_file.h"
#include "geometry/observation.h"
#include "geometry/plane.h"
#include "grasp/detector.h"
#include "grasp/mover.h"
#include "robot/robot.h"
#include "sensing/line_scanner.h"
#include "sensing/line_scanner_options.h"
#include "sim/world.h"
#include "trial/arranger.h"
#include "trial/options.h"

namespace rangegrasp::sensing {
struct DepthCameraOptions;
}

namespace rangegrasp::trial {

/// What a sensor measured, with the truth that only the judge may read.
struct Sensed {
  geometry::Observation observation;
  std::vector<sensing::ScanTruth> truth;  ///< one a view, in the layout of its image
};

/// Stage 2: looks at a settled world.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual Sensed Sense(const sim::World& world, base::Rng& rng) const = 0;
  /// Looks, and writes the cloud with what the sensor makes it from.
  /// @return what was written where, for a person; empty: there is nothing to write
  virtual std::string WriteLook(const sim::World& /*world*/, base::Rng& /*rng*/,
                                const std::filesystem::path& /*cloud*/) const {
    return "";
  }
  /// What it does once before its first look.
  virtual void Prepare() const {}
  /// Looks at a world so that later looks are faster, those of forked processes too.
  virtual void Rehearse(const sim::World&) const {}
  virtual bool Rehearses() const { return false; }  ///< whether that is of any use
};

/// The line scanner at its site. The options must outlive it.
std::unique_ptr<Sensor> MakeLineScanner(const sensing::LineScannerOptions& options,
                                        const base::Pose& X_WScanner);

/// A depth camera at its site or place.
std::unique_ptr<Sensor> MakeDepthCamera(const sensing::DepthCameraOptions& options);

/// What all trials of an experiment share: its options, what they name, and four parts. Made once,
/// before processes are forked; stays where it was made, since the parts refer to it.
struct Cell {
  /// @throws base::InputError for a scene, sensor or object that is not what it should be.
  explicit Cell(Options options);
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  /// Results lie there: no program in a sandbox sees them.
  void Hide(const std::filesystem::path& folder);

  geometry::Plane TablePlane() const;  ///< in W, as the scene's model has it

  Options options;
  robot::Robot robot;
  sensing::LineScannerOptions scanner;
  std::unique_ptr<Arranger> arranger;
  std::unique_ptr<Sensor> sensor;
  std::unique_ptr<Detector> detector;
  std::unique_ptr<Mover> mover;
};

/// Fields of a written cloud's points: "label", "state", and colors where the sensor sees them.
std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth);

}  // namespace rangegrasp::trial
