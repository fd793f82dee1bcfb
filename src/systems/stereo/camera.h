#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>

#include "base/frames.h"
#include "base/image/image.h"
#include "base/yaml_map.h"

namespace rangegrasp::stereo {

/// A pinhole camera with the distortion of equations 5.10 to 5.12, in its own frame S (x right, y
/// down, z forward). Pixel centers have integer coordinates: the upper left one is at (0, 0).
struct Camera {
  int width = 0;              ///< [px]
  int height = 0;             ///< [px]
  double fx = 0.0, fy = 0.0;  ///< focal lengths [px]
  double cx = 0.0, cy = 0.0;  ///< principal point [px]
  double k1 = 0.0, k2 = 0.0;  ///< radial distortion, of r^2 and r^4
  double p1 = 0.0, p2 = 0.0;  ///< tangential distortion
  double k3 = 0.0;            ///< of r^6; the dissertation's model has none

  bool operator==(const Camera&) const = default;
};

/// Where an undistorted point (x, y) = (X/Z, Y/Z) of the plane at Z = 1 appears on that plane, with
/// r^2 = x^2 + y^2:
///   x_d = x + x (k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)       (5.10)
///   y_d = y + y (k1 r^2 + k2 r^4 + k3 r^6) + 2 p2 x y + p1 (r^2 + 2 y^2)       (5.11)
/// The dissertation prints p1 and p2 in 5.11 as in 5.10. Its source, OpenCV's manual, exchanges
/// them; otherwise 5.10 and 5.11 would not be rotations of each other.
Eigen::Vector2d Distort(const Camera& camera, const Eigen::Vector2d& undistorted);

/// The inverse of Distort, by Newton's method from the distorted point.
/// @return NaN if it does not converge: where the distortion is not invertible.
Eigen::Vector2d Undistort(const Camera& camera, const Eigen::Vector2d& distorted);

/// The pixel in which the camera sees a point p_S [m]; NaN for a point that is not in front of it.
Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& p_S);

/// The direction (z = 1) of a pixel's ray; NaN like Undistort.
Eigen::Vector3d RayOf(const Camera& camera, const Eigen::Vector2d& pixel);

struct PicturePair {
  image::Image left, right;
  bool colour = true;  ///< false: from grey files; each channel has the brightness, nothing is blue
};

/// The pixel (red, green, blue) nearest to a place, which may lie outside the picture.
const std::uint8_t* NearestPixel(const image::Image& picture, const Eigen::Vector2d& place);

/// One camera that took two pictures, and its pose at each: section 5.3.2's pan of -4 (left) and 0
/// degrees (right).
struct StereoCalibration {
  Camera camera;
  base::Pose X_WL = base::Pose::Identity();  ///< the camera at the left picture, in the arm's frame
  base::Pose X_WR = base::Pose::Identity();  ///< the same at the right picture
  /// Residuals of the calibration, for information; 0: unknown.
  double reprojection_px = 0.0;  ///< root mean square over the corners
  double registration_m = 0.0;   ///< the same over the points shared by arm and camera
};

/// The pose of the right camera in the left one's frame, X_LR (R and T of equations 5.13 and 5.14
/// are those of its inverse).
base::Pose RightInLeft(const StereoCalibration& calibration);

/// YAML.
/// @throws base::InputError naming file, line and key; base::RunError if it cannot be written.
StereoCalibration ReadStereoCalibration(const std::filesystem::path& file);
void WriteStereoCalibration(const StereoCalibration& calibration,
                            const std::filesystem::path& file);

/// Reads a camera of a calibration file, to the end of the mapping.
/// @throws base::InputError naming file, line and key.
void ReadCamera(base::YamlMap& map, Camera& camera);

/// A mapping `name:` for ReadCamera, with all digits.
std::string CameraText(const std::string& name, const Camera& camera);

/// Two cameras with parallel axes, to which a pair is rectified so that corresponding pixels differ
/// only in their column (figure 5.19b).
struct RectifiedCameras {
  int width = 0;                             ///< [px]
  int height = 0;                            ///< [px]
  double f = 0.0;                            ///< focal length [px]
  double cx = 0.0, cy = 0.0;                 ///< principal point [px], of both
  double baseline_m = 0.0;                   ///< from the left camera to the right one
  base::Pose X_WS = base::Pose::Identity();  ///< the rectified left camera
  Eigen::Matrix3d R_LS;                      ///< its axes in the original left camera's frame
  Eigen::Matrix3d R_RS;                      ///< its axes in the original right camera's frame

  /// The direction (depth 1) in which the left camera sees (x, y).
  Eigen::Vector3d RayAt(double x, double y) const { return {(x - cx) / f, (y - cy) / f, 1.0}; }
  /// The point that the left camera sees at (x, y) and the right one at (x - disparity, y). Its
  /// depth is z = f baseline / disparity. The dissertation's d of equation 5.15 is -disparity.
  Eigen::Vector3d Triangulate(double x, double y, double disparity) const {
    return X_WS * (f * baseline_m / disparity * RayAt(x, y));
  }
  /// Change of depth [m] per pixel of disparity at a depth: z^2 / (f baseline).
  double DepthPerPixel(double depth_m) const { return depth_m * depth_m / (f * baseline_m); }
  double DisparityAt(double depth_m) const { return f * baseline_m / depth_m; }
};

/// The rectified cameras of a calibration, both rotated by the same amount (OpenCV's stereoRectify,
/// which is Bouguet's algorithm, as in the dissertation's calibration toolbox).
/// @throws base::InputError if size, focal lengths or principal point do not fit, or the right
/// camera is not to the right of the left one.
RectifiedCameras Rectify(const StereoCalibration& calibration);

/// Removes distortion (5.10 to 5.12) and rectifies both pictures: each pixel comes from one place
/// of the original by bilinear interpolation. Stores one table of places per picture.
class Rectifier {
 public:
  /// O(pixels). @throws base::InputError like Rectify.
  explicit Rectifier(const StereoCalibration& calibration);

  const RectifiedCameras& cameras() const { return cameras_; }

  /// Pictures of the rectified cameras; pixels that the original pictures do not show are black.
  /// @throws base::InputError if a picture's size is not the camera's.
  PicturePair Apply(const image::Image& left, const image::Image& right) const;

  /// The pixel of the original left picture that is mapped to (x, y). May lie outside the picture.
  Eigen::Vector2d LeftSource(double x, double y) const;

 private:
  struct Maps;
  Camera camera_;
  RectifiedCameras cameras_;
  std::shared_ptr<const Maps> maps_;
};

}  // namespace rangegrasp::stereo
