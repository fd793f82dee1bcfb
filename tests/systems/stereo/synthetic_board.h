#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "stereo/calibrate.h"
#include "stereo/camera.h"

/// Pictures of a chessboard in which every pixel is computed analytically.
namespace rangegrasp::testing_support {

inline base::Pose TurnedBy(const Eigen::Vector3d& rotation, const Eigen::Vector3d& shift) {
  return base::MakePose(
      Eigen::AngleAxisd(rotation.norm(), rotation.stableNormalized()).toRotationMatrix(), shift);
}

// A pixel is the mean of kParts x kParts places in a square of kSpot_px. No lens and sensor produce
// sharper pictures.
inline constexpr int kParts = 25;
inline constexpr double kSpot_px = 2.0;

inline stereo::Camera BoardCamera() {
  return {480, 360, 600.0, 600.0, 239.5, 179.5, 0.0, 0.0, 0.0, 0.0, 0.0};
}

/// A distortion-free camera's picture of a board on a grey background, blurred over `blur_px`.
inline image::Image BoardPicture(const base::Pose& X_CBoard,
                                 const stereo::ChessboardOptions& options, int blur_px) {
  const stereo::Camera camera = BoardCamera();
  const base::Pose X_BoardC = X_CBoard.inverse();
  const auto level = [&](double x, double y) {
    const Eigen::Vector3d ray = X_BoardC.linear() * stereo::RayOf(camera, {x, y});
    const Eigen::Vector3d p = X_BoardC.translation() - X_BoardC.translation().z() / ray.z() * ray;
    const double u = p.x() / options.square_m + 1.0, v = p.y() / options.square_m + 1.0;
    const double columns = options.columns + 1, rows = options.rows + 1;
    if (u < -0.7 || v < -0.7 || u > columns + 0.7 || v > rows + 0.7) return 120.0;
    if (u < 0.0 || v < 0.0 || u > columns || v > rows) return 230.0;
    return (static_cast<int>(u) + static_cast<int>(v)) % 2 == 0 ? 30.0 : 230.0;
  };
  const auto mean = [&](double x, double y) {
    // Squares are wider than a spot. If its corners have the same level, it contains no edge.
    constexpr double kHalf = 0.5 * kSpot_px;
    const double any = level(x - kHalf, y - kHalf);
    if (level(x + kHalf, y - kHalf) == any && level(x - kHalf, y + kHalf) == any &&
        level(x + kHalf, y + kHalf) == any) {
      return any;
    }
    const auto offset = [](int part) { return kSpot_px * ((part + 0.5) / kParts - 0.5); };
    double sum = 0.0;
    for (int row = 0; row < kParts; ++row) {
      for (int column = 0; column < kParts; ++column) {
        sum += level(x + offset(column), y + offset(row));
      }
    }
    return sum / (kParts * kParts);
  };
  std::vector<double> sharp;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) sharp.push_back(mean(x, y));
  }
  image::Image picture{camera.width, camera.height, {}};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0.0;
      int count = 0;
      for (int k = -blur_px / 2; k <= blur_px / 2; ++k) {
        if (x + k < 0 || x + k >= camera.width) continue;
        sum += sharp[static_cast<std::size_t>(y * camera.width + x + k)];
        ++count;
      }
      picture.rgb.insert(picture.rgb.end(), 3, static_cast<std::uint8_t>(std::lround(sum / count)));
    }
  }
  return picture;
}

}  // namespace rangegrasp::testing_support
