#pragma once

#include <span>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/observation.h"
#include "sensing/line_scanner_options.h"
#include "sensing/scan_truth.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing {

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
/// (Curless and Levoy 1995, "Better optical triangulation through spacetime analysis"); parts of
/// the image further apart than its own width are two blobs, of which the brighter is taken. The
/// centroid is disturbed, quantised, and triangulated on the sample's nominal ray.
///
/// Depends only on the arguments and rng's state (one draw of rng; every sample then has its own
/// draws, so that an object moved elsewhere does not change the noise here). Single-threaded; no
/// thread outlives the call.
/// @throws std::invalid_argument naming the option that is out of range, or the mesh and vertex or
/// triangle that is not finite or out of range.
Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const LineScannerOptions& options, base::Rng& rng);

}  // namespace rangegrasp::sensing
