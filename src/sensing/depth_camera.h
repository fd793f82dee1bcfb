#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sensing/range_sensor.h"

namespace rangegrasp::sensing {

/// Predicted standard deviation [m] of the depth by active stereo. With the disparity d = f b / z,
///   sigma_z = z^2 / (f b) sqrt(sigma_d^2 (s + (1 - s) / frames) + step^2 / 12),
/// where s is the share of the variance that is the same in all images (Keselman et al. 2017,
/// "Intel RealSense stereoscopic depth cameras", sub-pixel error of 0.08 px; Khoshelham and
/// Elberink 2012, "Accuracy and resolution of Kinect depth data for indoor mapping applications",
/// z^2).
double StereoSigma(const DepthCameraOptions& options, double depth_m);

/// Finds the pixels of a row that the second lens, `baseline` to the right, does not see. Draws the
/// disparities [px; 0: no surface] into the right image, nearer over farther.
/// @return 1 for a pixel that is hidden by a nearer surface there or lies outside that image
std::vector<std::uint8_t> HiddenFromRight(std::span<const float> disparity_px);

/// Noise of stereo matching: a field of mean 0 and variance 1, row by row. Pixels are correlated by
/// the overlap of their windows of window x rows pixels: at a distance of k pixels in a row the
/// correlation is 1 - k / window. O(width * height).
std::vector<float> WindowNoise(int width, int height, int window, int rows, std::uint64_t seed);

/// Simulates one image of the meshes. Depth is measured at the center of each pixel; a sample is
///   - out of view: no surface, depth out of range, or outside the second image;
///   - in shadow: seen, but hidden from the second lens (active stereo);
///   - a drop-out: lost on a dark, clear, glossy or grazing surface, or at a depth edge;
///   - moved across a nearby depth edge, or between its two surfaces (flying pixels): a stereo
///     window sees both, a time-of-flight pixel adds up light of both.
/// Depth edges have a lateral noise of about a pixel (Nguyen et al. 2012, "Modeling Kinect sensor
/// noise for improved 3D reconstruction and tracking": 0.8 px). Not simulated: multipath light
/// (which bends corners in time of flight), motion, other cameras, sunlight.
///
/// The view is like the line scanner's: points in W, computed with the pose that the robot knows,
/// on the nominal rays of the pixels; noise_m is predicted as by StereoSigma. An image row is a
/// profile.
///
/// Depends only on the arguments and one draw of rng. Single-threaded.
/// @throws std::invalid_argument like geometry::RayCaster.
Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const DepthCameraOptions& options, base::Rng& rng);

}  // namespace rangegrasp::sensing
