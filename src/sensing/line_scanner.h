#pragma once

#include <span>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/observation.h"
#include "geometry/point_cloud.h"
#include "sensing/line_scanner_options.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing {

/// Why a sample of the range image is what it is. A sample is a laser ray: what lies in the laser's
/// shadow has none (see ClassifySurface).
enum class SampleState : std::uint8_t {
  kMeasured,
  kCameraShadow,  ///< lit by the laser, within the camera's view, but hidden from the camera
  kDropout,       ///< seen, but lost to grazing incidence, low albedo, gloss or clarity
  kOutOfView      ///< the ray meets nothing, or its spot lies outside the sensor's window
};

/// What only the scorer may read; the same layout as the image. Of a measured sample: the surface
/// that gave most of its light; of any other: the first surface that the ray meets.
struct ScanTruth {
  std::vector<SampleState> state;
  std::vector<std::uint32_t> label;  ///< 0 where nothing was met
  std::vector<double> true_range_m;  ///< from the laser to that surface; NaN where nothing
};

/// Predicted standard deviation [m] of the depth of a plane, at a depth:
///   sigma_z^2 = (Zc^2 p / (f b))^2 (sigma_centroid^2 + sigma_speckle^2 + quantisation^2 / 12) with
/// Zc the distance along the camera's axis, p the pixel pitch, all sigmas in pixels. Without the
/// pan's jitter, which moves whole profiles.
double DepthSigma(const LineScannerOptions& options, double depth_m);

struct Scan {
  /// What the robot knows: points in W by the nominal calibration X_WS and the nominal pan angles.
  /// The one origin is the laser's exit point; X_CV is X_WS; noise_m is DepthSigma at the sample's
  /// measured depth, turned into the ray's direction; spacing_m is geometry::MedianSpacing.
  geometry::View view;
  ScanTruth truth;
};

/// One sweep over the meshes. Per sample: a ray from the laser to the first surface, a second one
/// to the camera, which decides whether the spot is seen; near edges (of depth, orientation,
/// visibility or reflectance) further rays over the line's width and the sample's length, whose
/// images' centroid, weighted by the light that reaches the camera, bends there as the real one's
/// (Curless and Levoy 1995, "Better optical triangulation through spacetime analysis"); of parts
/// further apart than the image's own width the brighter counts. The centroid is disturbed,
/// quantised, and triangulated on the sample's nominal ray.
///
/// Depends only on the arguments and one draw of rng; every sample has its own draws, so that an
/// object moved elsewhere does not change the noise here. Single-threaded.
/// @throws std::invalid_argument naming the option that is out of range, or the mesh and vertex or
/// triangle that is not finite or out of range.
Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const LineScannerOptions& options, base::Rng& rng);

/// What scanner and surroundings make of a point of a surface.
enum class SurfaceState : std::uint8_t {
  kSeen,          ///< lit, and open to the camera
  kLaserShadow,   ///< open to the camera, not lit
  kCameraShadow,  ///< lit, hidden from the camera
  kBothShadows,
  kOutOfView  ///< outside the sweep, the fan or the sensor's window
};

/// Classifies points [m] of a surface, each at the pan angle whose fan passes through it: is the
/// segment to the laser free, and the one to the camera? Surfaces within 0.5 mm of a point hide it
/// from nothing. Independent of sampling, noise, drop-outs and orientation.
/// @throws std::invalid_argument as ScanScene.
std::vector<SurfaceState> ClassifySurface(geometry::PointSpan points_W,
                                          std::span<const sim::VisualMesh> meshes,
                                          const base::Pose& X_WS,
                                          const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
