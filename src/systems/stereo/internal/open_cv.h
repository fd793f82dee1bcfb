#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "base/image/image.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo::internal {

/// While it lives OpenCV works in this thread alone: trials run in parallel, in forked processes,
/// in which the threads of their parent are not there.
class SingleThread {
 public:
  SingleThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~SingleThread() { cv::setNumThreads(before_); }
  SingleThread(const SingleThread&) = delete;
  SingleThread& operator=(const SingleThread&) = delete;

 private:
  int before_;
};

/// Of a pixel among those of a picture, row after row.
inline std::size_t IndexAt(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

/// A picture's pixels as OpenCV sees them: not a copy, and not to be written to.
inline cv::Mat View(const image::Image& picture) {
  return cv::Mat(
      picture.height, picture.width, CV_8UC3,
      const_cast<std::uint8_t*>(picture.rgb.data()));  // NOLINT: OpenCV has no const view
}

/// Room for a picture, and the matrix that writes to it.
inline cv::Mat Room(int width, int height, image::Image& picture) {
  picture.width = width;
  picture.height = height;
  picture.rgb.assign(3 * IndexAt(0, height, width), 0);
  return cv::Mat(height, width, CV_8UC3, picture.rgb.data());
}

inline cv::Matx33d MatrixOf(const Camera& c) {
  return {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0};
}

inline cv::Vec<double, 5> DistortionOf(const Camera& c) { return {c.k1, c.k2, c.p1, c.p2, c.k3}; }

inline cv::Matx33d FromEigen(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

inline Eigen::Matrix3d ToEigen(const cv::Matx33d& m) {
  Eigen::Matrix3d result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) result(row, column) = m(row, column);
  }
  return result;
}

}  // namespace rangegrasp::stereo::internal
