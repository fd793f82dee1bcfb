#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "base/rng.h"
#include "base/units.h"
#include "stereo/camera.h"

/// A table with boxes, seen by two cameras. Every pixel is computed analytically, so the correct
/// reconstruction is known up to rounding.
namespace rangegrasp::testing_support {

using Eigen::Vector3d;

/// An axis-aligned box with a print (a smooth random pattern) or of uniform grey.
struct TexturedBox {
  Vector3d min_W, max_W;
  bool printed = true;
};

struct SyntheticScene {
  std::vector<TexturedBox> boxes;
};

/// The first hit of a ray: its distance in multiples of the direction, and the box (-1: table).
struct Hit {
  double along = std::numeric_limits<double>::infinity();
  int box = -1;
};

inline Hit Meet(const SyntheticScene& scene, const Vector3d& origin, const Vector3d& direction) {
  Hit hit;
  if (direction.z() < 0.0) hit.along = -origin.z() / direction.z();
  for (std::size_t b = 0; b < scene.boxes.size(); ++b) {
    const Eigen::Array3d a = (scene.boxes[b].min_W - origin).array() / direction.array();
    const Eigen::Array3d c = (scene.boxes[b].max_W - origin).array() / direction.array();
    const double in = a.min(c).maxCoeff(), out = a.max(c).minCoeff();
    if (in < out && in > 0.0 && in < hit.along) hit = {in, static_cast<int>(b)};
  }
  return hit;
}

/// A smooth, repeatable pattern between 0 and 1, from random values at the corners of cells.
inline double Pattern(const Vector3d& p, double cell_m) {
  const Vector3d q = p / cell_m;
  const Vector3d low(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
  const Vector3d t = q - low;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::uint64_t seed = 7;
    for (int i = 0; i < 3; ++i) {
      const int bit = (corner >> i) & 1;
      const double s = t[i] * t[i] * (3.0 - 2.0 * t[i]);
      weight *= bit ? s : 1.0 - s;
      seed = base::DeriveSeed(
          seed, static_cast<std::uint64_t>(static_cast<std::int64_t>(low[i]) + bit + (1 << 20)));
    }
    sum += weight * static_cast<double>(seed % 1000) / 1000.0;
  }
  return sum;
}

inline std::uint8_t Level(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 1L, 255L));
}

/// The picture of a camera at X_WS, with white noise in each channel.
inline image::Image Picture(const SyntheticScene& scene, const stereo::Camera& camera,
                            const base::Pose& X_WS, double noise_levels, std::uint64_t seed) {
  image::Image picture{camera.width, camera.height, {}};
  base::Rng rng(seed);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d direction = X_WS.rotation() * stereo::RayOf(camera, Eigen::Vector2d(x, y));
      const Hit hit = Meet(scene, X_WS.translation(), direction);
      Eigen::Array3d colour(40.0, 60.0, 150.0);  // the table
      if (hit.box >= 0) {
        const Vector3d p_W = X_WS.translation() + hit.along * direction;
        const double print = scene.boxes[static_cast<std::size_t>(hit.box)].printed
                                 ? 0.4 + 0.6 * Pattern(p_W, 0.008)
                                 : 0.8;
        colour = Eigen::Array3d(220.0, 200.0, 180.0) * print;
      }
      for (int c = 0; c < 3; ++c) {
        picture.rgb.push_back(Level(colour[c] + noise_levels * rng.Normal()));
      }
    }
  }
  return picture;
}

/// The pose of a camera that looks down at the table, rotated about a vertical axis 0.3 m behind
/// it.
inline base::Pose LookingDown(double pan_rad) {
  const Eigen::AngleAxisd pan(pan_rad, Vector3d::UnitZ());
  const Vector3d axis_W(0.75, 0.0, 0.55);
  const double pitch = base::Deg(-45.0);
  Eigen::Matrix3d R;  // forward points to -x and down
  const Vector3d forward(-std::cos(pitch), 0.0, std::sin(pitch));
  const Vector3d right(0.0, 1.0, 0.0);
  R.col(0) = right;
  R.col(2) = forward;
  R.col(1) = forward.cross(right);
  return base::MakePose(pan * R, axis_W + pan * Vector3d(-0.3, 0.0, 0.0));
}

/// A small camera with the distortion of a cheap lens. It is rotated by 10 degrees to the left,
/// which gives a baseline of 52 mm.
inline stereo::StereoCalibration SyntheticCalibration() {
  stereo::StereoCalibration calibration;
  calibration.camera = {400, 300, 500.0, 503.0, 204.0, 147.0, -0.15, 0.05, 5e-4, -4e-4, 0.0};
  calibration.X_WL = LookingDown(base::Deg(10.0));
  calibration.X_WR = LookingDown(0.0);
  return calibration;
}

/// A printed box and a grey one.
inline SyntheticScene TwoBoxes() {
  return {{{{-0.04, -0.11, 0.0}, {0.04, -0.02, 0.09}, true},
           {{-0.03, 0.03, 0.0}, {0.05, 0.11, 0.06}, false}}};
}

}  // namespace rangegrasp::testing_support
