#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/image/image.h"
#include "base/rng.h"
#include "stereo/camera.h"

namespace rangegrasp::sensing::internal {

/// How an ideal picture, drawn by a camera without distortion, becomes what a lens images
/// (equations 5.10 to 5.12): for each pixel of the photograph the place in the drawn picture that
/// it sees. The drawn picture has the lens's focal length and is as much larger as it must be to
/// hold all that the lens sees.
class LensMap {
 public:
  /// @param camera  square pixels: fx is fy.
  /// @throws std::invalid_argument if its distortion cannot be undone within the picture.
  explicit LensMap(const stereo::Camera& camera);

  int drawn_width() const { return drawn_width_; }
  int drawn_height() const { return drawn_height_; }
  /// Principal point of the drawn picture [px].
  const Eigen::Vector2d& drawn_center_px() const { return drawn_center_; }

  /// A row of the photograph: `out` receives 3 values a pixel in units of 1 / kOne of a grey level,
  /// interpolated between the four nearest drawn pixels.
  static constexpr int kOne = 1 << 6;
  void SampleRow(const image::Image& drawn, int row, std::vector<std::int32_t>& out) const;

 private:
  struct Place {
    std::uint32_t pixel;        // the upper left of the four, as an index into rgb
    std::uint16_t right, down;  // shares of the others, of kShare
  };
  int width_;
  int drawn_width_ = 0;
  int drawn_height_ = 0;
  Eigen::Vector2d drawn_center_;
  std::vector<Place> places_;
};

/// The picture smoothed along rows and columns by three weights, whose variance is sigma_px^2
/// (<= 1): a Gaussian's of that width, near enough.
void Blur(image::Image& picture, double sigma_px);

/// Normal numbers, fast: quantiles of the normal distribution, of which 12 random bits pick one.
class PixelNoise {
 public:
  /// @param sigma  standard deviation of what Fill gives, in its units.
  explicit PixelNoise(double sigma);
  /// Adds a draw to each value.
  void AddTo(std::vector<std::int32_t>& values, base::Rng& rng) const;

 private:
  std::vector<std::int32_t> quantiles_;
};

}  // namespace rangegrasp::sensing::internal
