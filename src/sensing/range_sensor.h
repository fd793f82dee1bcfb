#pragma once

#include <filesystem>
#include <span>
#include <variant>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/observation.h"
#include "sensing/line_scanner.h"
#include "sensing/range_sensor_options.h"
#include "sim/world.h"

namespace rangegrasp::sensing {

/// A range sensor: its samples are rays from one head.
using RangeSensor = std::variant<LineScannerOptions, DepthCameraOptions>;

/// Reads a sensor's file of either type. @throws base::InputError naming file, line and key.
RangeSensor ReadRangeSensor(const std::filesystem::path& file);

const RangeSensorOptions& SharedOf(const RangeSensor& sensor);
RangeSensorOptions& SharedOf(RangeSensor& sensor);

/// Field of view in the sensor's frame S.
geometry::Field FieldOf(const RangeSensor& sensor);

/// The sensor's pose in a world. @throws base::InputError if the scene does not have its site
base::Pose PoseIn(const sim::World& world, const RangeSensor& sensor);

Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const RangeSensor& sensor, base::Rng& rng);

}  // namespace rangegrasp::sensing
