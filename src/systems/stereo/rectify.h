#pragma once

#include <Eigen/Core>
#include <memory>

#include "base/frames.h"
#include "base/image/image.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo {

/// Two cameras with parallel axes, one pinhole and one row for each point: what the pictures of a
/// pair are turned into, so that corresponding pixels differ in their column alone (figure 5.19b).
struct RectifiedCameras {
  int width = 0;                             ///< [px]
  int height = 0;                            ///< [px]
  double f = 0.0;                            ///< focal length [px]
  double cx = 0.0, cy = 0.0;                 ///< principal point [px], of both
  double baseline_m = 0.0;                   ///< from the left camera to the right one
  base::Pose X_WS = base::Pose::Identity();  ///< the left one, turned
  Eigen::Matrix3d R_LS;                      ///< its axes in those of the camera as it stood
  Eigen::Matrix3d R_RS;                      ///< and in those of the right one

  /// The point that the left camera sees at (x, y) and the right one at (x - disparity, y): at the
  /// depth z = f baseline / disparity. The dissertation's d of equation 5.15 is -disparity.
  Eigen::Vector3d Triangulate(double x, double y, double disparity) const;
  /// Depth [m] by which a pixel of disparity moves a point at that depth: z^2 / (f baseline).
  double DepthPerPixel(double depth_m) const { return depth_m * depth_m / (f * baseline_m); }
  double DisparityAt(double depth_m) const { return f * baseline_m / depth_m; }
};

/// The two cameras of a calibration, both turned by the same amount (OpenCV's stereoRectify, which
/// is Bouguet's: as in the toolbox that the dissertation calibrates with).
/// @throws base::InputError if the right camera is not to the right of the left one, or the places
/// are not beside but above or before each other.
RectifiedCameras Rectify(const StereoCalibration& calibration);

/// A pair in the layout of the rectified cameras. What neither camera saw is black.
struct RectifiedPair {
  image::Image left;
  image::Image right;
};

/// Undoes distortion (5.10 to 5.12) and turns both pictures, each pixel from one place of the
/// original by bilinear interpolation. Holds one table of places a picture.
class Rectifier {
 public:
  /// O(pixels). @throws base::InputError as Rectify and CheckCalibration.
  explicit Rectifier(const StereoCalibration& calibration);
  ~Rectifier();
  Rectifier(Rectifier&&) noexcept;

  const RectifiedCameras& cameras() const { return cameras_; }
  const Camera& camera() const { return camera_; }

  /// @throws base::InputError if a picture's size is not the camera's: the calibration is another
  /// camera's.
  RectifiedPair Apply(const image::Image& left, const image::Image& right) const;

  /// The pixel of the left picture that comes to stand at (x, y). May lie outside of it.
  Eigen::Vector2d LeftSource(double x, double y) const;

 private:
  struct Maps;
  Camera camera_;
  RectifiedCameras cameras_;
  std::unique_ptr<const Maps> maps_;
};

}  // namespace rangegrasp::stereo
