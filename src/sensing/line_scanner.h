#pragma once

#include "sensing/range_sensor.h"

namespace rangegrasp::sensing {

/// Predicted standard deviation [m] of the depth of a plane at a given depth:
///   sigma_z^2 = (Zc^2 p / (f b))^2 (sigma_centroid^2 + sigma_speckle^2 + quantisation^2 / 12),
/// where Zc is the distance along the camera's axis, p the pixel pitch, and all sigmas are in
/// pixels. Does not include the pan jitter, which moves whole profiles.
double DepthSigma(const LineScannerOptions& options, double depth_m);

/// Simulates one sweep over the meshes. Each sample has a ray from the laser to the first surface
/// and a second one to the camera, which decides whether the spot is seen. Near edges (of depth,
/// orientation, visibility or reflectance) it has additional rays over the line's width and the
/// sample's length. The centroid of their images, weighted by the light that reaches the camera, is
/// biased like that of a real scanner (Curless and Levoy 1995, "Better optical triangulation
/// through spacetime analysis"). If the image splits into parts further apart than its own width,
/// the brighter one counts. Noise is added to the centroid; it is quantized and triangulated on the
/// sample's nominal ray.
///
/// Depends only on the arguments and one draw of rng. Every sample has its own draws, so that
/// moving an object does not change the noise elsewhere. Single-threaded.
/// @throws std::invalid_argument naming the option that is out of range, or the mesh and vertex or
/// triangle that is not finite or out of range.
Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const LineScannerOptions& options, base::Rng& rng);

/// Visibility of a surface point from the scanner.
enum class SurfaceState : std::uint8_t {
  kSeen,          ///< lit, and open to the camera
  kLaserShadow,   ///< open to the camera, not lit
  kCameraShadow,  ///< lit, hidden from the camera
  kBothShadows,
  kOutOfView  ///< outside the sweep, the fan or the sensor's window
};

/// Classifies points [m] of a surface, each at the pan angle at which the fan passes through it, by
/// whether the segments to the laser and to the camera are free. Surfaces within 0.5 mm of a point
/// do not hide it. Independent of sampling, noise, drop-outs and orientation.
/// @throws std::invalid_argument like ScanScene.
std::vector<SurfaceState> ClassifySurface(geometry::PointSpan points_W,
                                          std::span<const sim::VisualMesh> meshes,
                                          const base::Pose& X_WS,
                                          const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
