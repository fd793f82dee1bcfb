#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "sensing/depth_camera_options.h"
#include "sensing/line_scanner.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing {

/// Predicted standard deviation [m] of the depth of active stereo: with the disparity d = f b / z,
///   sigma_z = z^2 / (f b) sqrt(sigma_d^2 (s + (1 - s) / frames) + step^2 / 12),
/// s the share of the variance that is the same in all images (Keselman et al. 2017, "Intel
/// RealSense stereoscopic depth cameras", sub-pixel error of 0.08 px; Khoshelham and Elberink 2012,
/// "Accuracy and resolution of Kinect depth data for indoor mapping applications", z^2).
double StereoSigma(const DepthCameraOptions& options, double depth_m);

/// The same of the range by time of flight [m]: of the light that comes back, A ~ albedo cos(i) /
/// range^2, the shot noise goes with the inverse root (Lange and Seitz 2001, "Solid-state
/// time-of-flight range camera"):
///   sigma = range_sigma range sqrt(0.85 / (albedo cos(i))) sqrt(s + (1 - s) / frames).
double FlightSigma(const DepthCameraOptions& options, double range_m, double reflected);

/// What of a row the second lens, `baseline` to the right, does not see: its disparities [px; 0:
/// nothing was met] are drawn into the right image, nearer over farther.
/// @return 1 for a pixel that something nearer hides there, or that lies outside that image
std::vector<std::uint8_t> HiddenFromRight(std::span<const float> disparity_px);

/// Noise of a matching window: a field of mean 0 and variance 1, row after row, in which pixels
/// share what their windows of window x rows pixels share: along a row the correlation at k pixels
/// is 1 - k / window. O(width * height).
std::vector<float> WindowNoise(int width, int height, int window, int rows, std::uint64_t seed);

/// One image of the meshes. Depth is measured in the middle of each pixel; a sample is
///   - out of view: nothing is met, its depth is out of range, or it lies beyond the second image;
///   - in shadow: seen, but hidden from the second lens (active stereo);
///   - a drop-out: lost to a dark, clear, glossy or grazing surface, or at a depth edge;
///   - moved across a nearby depth edge, or between its two surfaces (flying pixels): a stereo
///     window sees both, a time-of-flight pixel adds up light of both.
/// Depth edges wander by about a pixel (Nguyen et al. 2012, "Modeling Kinect sensor noise for
/// improved 3D reconstruction and tracking": 0.8 px). Not simulated: light that goes several ways
/// (time of flight bends corners), motion, other cameras, sunlight.
///
/// The view is as the line scanner's: points in W by the pose that the robot knows, on the pixels'
/// nominal rays; noise_m is StereoSigma or FlightSigma. A row of the image is a profile.
///
/// Depends only on the arguments and one draw of rng. Single-threaded.
/// @throws std::invalid_argument as of the line scanner.
Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const DepthCameraOptions& options, base::Rng& rng);

}  // namespace rangegrasp::sensing
