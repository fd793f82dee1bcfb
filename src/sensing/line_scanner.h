#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/frames.h"
#include "core/rng.h"
#include "core/units.h"
#include "geometry/range_image.h"
#include "geometry/visual_mesh.h"

namespace rangegrasp::sensing {

/// A laser plane and a camera on one head that pans. The head's frame S (x right, y down, z
/// forward) has its origin in the laser's exit point; the pan axis is S's y axis. In the frame P of
/// one profile (S turned by the pan angle) the laser's fan is the half plane x = 0, z > 0 with its
/// apex in the origin, and the camera stands at (baseline, 0, 0), turned about y so that its axis
/// meets the fan at z = focus_distance. "Depth" is z_P.
///
/// Defaults: a 512 x 512 sensor with 9.5 um pixels and a lens that sees the whole fan with the 512
/// columns; of its rows a window is read that ends before the floor behind the table.
struct LineScannerOptions {
  int samples = 512;  ///< a profile: rays evenly spaced in the tangent of the fan's angle
  int profiles = 150;
  double fan_rad = core::Deg(42.0);        ///< opening of the fan, and of the camera along the line
  double pan_range_rad = core::Deg(34.0);  ///< from first to last profile, symmetric round S's z
  double baseline_m = 0.30;
  double focal_length_m = 0.0063;
  double pixel_pitch_m = 9.5e-6;
  int sensor_pixels = 256;        ///< read across the line: limits the depths that are seen
  double focus_distance_m = 0.9;  ///< depth at which the camera's axis meets the fan
  double near_m = 0.20;  ///< surfaces nearer to the head than this are its own and hide nothing
  double line_width_m = 0.001;       ///< 1/e^2 width of the (collimated) line on a surface
  double blur_px = 2.5;              ///< 1/e^2 width that lens and pixels add to the line's image
  double centroid_sigma_px = 0.07;   ///< white noise of the line's centroid
  double speckle_sigma_m = 0.0002;   ///< depth noise by speckle at a depth of 1 m
  double correlation_samples = 2.0;  ///< 1/e length of the speckle along the line
  double quantisation_px = 0.0625;   ///< step of the centroid; 0: none
  double pan_jitter_rad = core::Deg(0.02);       ///< sigma of the pan angle, one value a profile
  double dropout_begin_rad = core::Deg(60.0);    ///< incidence from which samples drop out
  double dropout_end_rad = core::Deg(80.0);      ///< incidence from which all are lost
  double saturation_angle_rad = core::Deg(5.0);  ///< gloss blinds this near the mirror direction
};

/// Reads models/sensors/*.yaml; keys are the option names in human units (documented in the file);
/// what is not given keeps its default.
/// @throws core::InputError naming file, line and key (and the nearest valid key for an unknown
/// one) if the file cannot be read, a key is unknown or twice, or a value is of the wrong type or
/// out of range.
LineScannerOptions ReadLineScanner(const std::filesystem::path& file);

/// Predicted standard deviation [m] of the depth of a plane, at a depth:
///   sigma_z^2 = (Zc^2 p / (f b))^2 (sigma_centroid^2 + sigma_speckle^2 + quantisation^2 / 12) with
/// Zc the distance along the camera's axis, p the pixel pitch, all sigmas in pixels. Without the
/// pan's jitter, which moves whole profiles.
double DepthSigma(const LineScannerOptions& options, double depth_m);

/// Why a sample of the range image is what it is. A sample is a laser ray, so that what lies in the
/// laser's shadow has no sample at all (the image jumps there): see ClassifySurface.
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

struct Scan {
  /// In W by the nominal calibration X_WS and the nominal pan angles: what the robot knows. Its
  /// one origin is the laser's exit point.
  geometry::RangeImage image;
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
Scan ScanScene(std::span<const geometry::VisualMesh> meshes, const core::Pose& X_WS,
               const LineScannerOptions& options, core::Rng& rng);

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
                                          std::span<const geometry::VisualMesh> meshes,
                                          const core::Pose& X_WS,
                                          const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
