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
#include "robot/robot.h"
#include "sensing/range_sensor.h"
#include "sim/world.h"
#include "trial/arranger.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// An observation, with the ground truth that only the judge may read.
struct Sensed {
  geometry::Observation observation;
  std::vector<sensing::ScanTruth> truth;  ///< one per view, in the layout of its image
};

/// Stage 2: scans a settled world.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual Sensed Sense(const sim::World& world, base::Rng& rng) const = 0;
  virtual bool WritesLook() const { return false; }  ///< whether WriteLook is implemented
  /// Scans, and writes the cloud and the sensor's images.
  /// @return a message with the written files
  virtual std::string WriteLook(const sim::World& /*world*/, base::Rng& /*rng*/,
                                const std::filesystem::path& /*cloud*/) const {
    return "";
  }
  /// Called once before the first scan.
  virtual void Prepare() const {}
  /// Scans a world so that later scans are faster, also those of forked processes.
  virtual void Rehearse(const sim::World&) const {}
  virtual bool Rehearses() const { return false; }  ///< whether Rehearse has an effect
};

/// Everything that the trials of an experiment share: the options, the robot, and the arranger,
/// sensor and detector. Made once, before processes are forked. It cannot be copied or
/// moved, since its parts refer to it.
struct Cell {
  /// @throws base::InputError for an invalid scene, sensor or object.
  explicit Cell(Options options);
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  /// Hides a folder of results from detectors in a sandbox.
  void Hide(const std::filesystem::path& folder);

  geometry::Plane TablePlane() const;  ///< in W, from the scene's model

  Options options;
  robot::Robot robot;
  sensing::LineScannerOptions scanner;
  std::unique_ptr<Arranger> arranger;
  std::unique_ptr<Sensor> sensor;
  std::unique_ptr<Detector> detector;
};

/// The cell's line scanner at its pose. The cell must outlive it.
std::unique_ptr<Sensor> MakeLineScanner(const Cell& cell);

/// The depth camera of the cell's sensor file, at its site or pose.
std::unique_ptr<Sensor> MakeDepthCamera(const Cell& cell);

/// Fields of a written cloud's points: "label", "state", and colors if the sensor measures them.
std::vector<geometry::CloudField> TruthFields(const geometry::View& view,
                                              const sensing::ScanTruth& truth);

}  // namespace rangegrasp::trial
