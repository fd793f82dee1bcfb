#pragma once

#include <Eigen/Core>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "base/frames.h"
#include "base/image/image.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo::internal {

/// Restricts OpenCV to this thread during its lifetime: trials run in parallel in forked processes,
/// which do not have the threads of their parent.
class SingleThread {
 public:
  SingleThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~SingleThread() { cv::setNumThreads(before_); }
  SingleThread(const SingleThread&) = delete;
  SingleThread& operator=(const SingleThread&) = delete;

 private:
  int before_;
};

/// A picture's pixels for OpenCV: not a copy, and not to be written to.
inline cv::Mat View(const image::Image& picture) {
  return {picture.height, picture.width, CV_8UC3,
          const_cast<std::uint8_t*>(picture.rgb.data())};  // NOLINT: OpenCV has no const view
}
template <typename Pixel>
cv::Mat View(const image::Grey<Pixel>& picture) {
  return {picture.height, picture.width, cv::DataType<Pixel>::type,
          const_cast<Pixel*>(picture.grey.data())};  // NOLINT: OpenCV has no const view
}

inline cv::Mat GreyOf(const image::Image& picture) {
  cv::Mat grey;
  cv::cvtColor(View(picture), grey, cv::COLOR_RGB2GRAY);
  return grey;
}

/// Allocates a picture, and returns the matrix that writes to it.
inline cv::Mat Room(int width, int height, image::Image& picture) {
  picture = {width, height, std::vector<std::uint8_t>(3 * image::IndexAt(0, height, width), 0)};
  return {height, width, CV_8UC3, picture.rgb.data()};
}
inline cv::Mat Room(int width, int height, image::Grey8& picture) {
  picture = {width, height, std::vector<std::uint8_t>(image::IndexAt(0, height, width), 0)};
  return {height, width, CV_8UC1, picture.grey.data()};
}

inline cv::Matx33d MatrixOf(const Camera& c) {
  return {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0};
}

inline cv::Vec<double, 5> DistortionOf(const Camera& c) { return {c.k1, c.k2, c.p1, c.p2, c.k3}; }

inline cv::Matx33d FromEigen(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
inline cv::Vec3d ShiftOf(const base::Pose& X) {
  return {X.translation().x(), X.translation().y(), X.translation().z()};
}

inline Eigen::Matrix3d ToEigen(const cv::Matx33d& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.val);
}

inline base::Pose PoseOf(const cv::Matx33d& rotation, const cv::Vec3d& shift) {
  return base::MakePose(ToEigen(rotation), {shift[0], shift[1], shift[2]});
}
/// Pose from a rotation vector, as OpenCV's solvers return it.
inline base::Pose PoseOfTurn(const cv::Vec3d& turn, const cv::Vec3d& shift) {
  cv::Matx33d rotation;
  cv::Rodrigues(turn, rotation);
  return PoseOf(rotation, shift);
}

}  // namespace rangegrasp::stereo::internal
