#pragma once

#include <filesystem>
#include <memory>

#include "geometry/plane.h"
#include "grasp/detector.h"
#include "grasp/mover.h"
#include "robot/robot.h"
#include "sensing/line_scanner_options.h"
#include "trial/arranger.h"
#include "trial/options.h"
#include "trial/sensor.h"

namespace rangegrasp::trial {

/// What all trials of an experiment share: its options, what they name, and the four parts that can
/// be replaced. Made once, before processes are forked; stays where it was made, since the parts
/// refer to it.
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

}  // namespace rangegrasp::trial
