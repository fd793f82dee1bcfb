#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/frames.h"
#include "geometry/point_cloud.h"
#include "sensing/line_scanner_options.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing {

/// What scanner and surroundings make of a point of a surface.
enum class SurfaceState : std::uint8_t {
  kSeen,          ///< lit, and open to the camera
  kLaserShadow,   ///< open to the camera, not lit
  kCameraShadow,  ///< lit, hidden from the camera
  kBothShadows,
  kOutOfView  ///< outside the sweep, the fan or the sensor's window
};

/// Classifies points [m] of a surface (of the table's plane, say), each at the pan angle whose fan
/// passes through it: is the segment to the laser free, and the one to the camera? Surfaces within
/// 0.5 mm of a point hide it from nothing, so that it may lie on a mesh itself. Independent of the
/// sampling, noise and drop-outs; orientation plays no part.
/// @throws std::invalid_argument as ScanScene.
std::vector<SurfaceState> ClassifySurface(geometry::PointSpan points_W,
                                          std::span<const sim::VisualMesh> meshes,
                                          const base::Pose& X_WS,
                                          const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
