#include "stereo/sensing/internal/lens.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rangegrasp::sensing::internal {
namespace {

stereo::Camera Lens() {
  return {200, 150, 250.0, 250.0, 101.3, 72.8, -0.11, 0.14, 6e-4, -4e-4, 0.0};
}

/// A picture whose red is the column and whose green is the row.
image::Image Ruler(int width, int height) {
  image::Image picture{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      picture.rgb.push_back(static_cast<std::uint8_t>(x));
      picture.rgb.push_back(static_cast<std::uint8_t>(y));
      picture.rgb.push_back(0);
    }
  }
  return picture;
}

// A pixel shows what lies on its ray (equations 5.10 to 5.12, undone).
TEST(LensMap, ShowsWhatEachPixelsRaySees) {
  const stereo::Camera lens = Lens();
  const LensMap map(lens);
  ASSERT_LT(map.drawn_width(), 256);
  const image::Image ruler = Ruler(map.drawn_width(), map.drawn_height());
  std::vector<std::int32_t> row;
  for (int y = 0; y < lens.height; ++y) {
    map.SampleRow(ruler, y, row);
    for (int x = 0; x < lens.width; ++x) {
      const Eigen::Vector2d wanted =
          lens.fx * stereo::RayOf(lens, {x, y}).head<2>() + map.drawn_center_px();
      const auto at = 3 * static_cast<std::size_t>(x);
      // Places are kept to 1/256 px, values to 1/64 of a level.
      EXPECT_NEAR(double(row[at]) / LensMap::kOne, wanted.x(), 0.03);
      EXPECT_NEAR(double(row[at + 1]) / LensMap::kOne, wanted.y(), 0.03);
    }
  }
}

TEST(LensMap, RefusesADistortionThatFoldsThePicture) {
  stereo::Camera lens = Lens();
  lens.k1 = -3.0;
  EXPECT_THROW(LensMap{lens}, std::invalid_argument);
}

TEST(Blur, SpreadsAPointByItsDeviation) {
  image::Image picture{9, 9, std::vector<std::uint8_t>(9 * 9 * 3, 0)};
  picture.rgb[3 * (4 * 9 + 4)] = 255;
  Blur(picture, 0.6);
  double sum = 0.0, squares = 0.0;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const double red = picture.rgb[static_cast<std::size_t>(3 * (y * 9 + x))];
      sum += red;
      squares += red * (x - 4) * (x - 4);
    }
  }
  EXPECT_NEAR(sum, 255, 5);                     // nine roundings
  EXPECT_NEAR(squares / sum, 0.6 * 0.6, 0.02);  // of levels of 255
}

TEST(PixelNoise, HasItsDeviationAndNoMean) {
  const PixelNoise noise(192.0);
  base::Rng rng(4);
  std::vector<std::int32_t> values(1000000, 0);
  noise.AddTo(values, rng);
  double sum = 0.0, squares = 0.0;
  for (const std::int32_t value : values) {
    sum += value;
    squares += double(value) * value;
  }
  const auto n = static_cast<double>(values.size());
  EXPECT_NEAR(sum / n, 0.0, 5 * 192 / std::sqrt(n));
  // Five standard errors; 4,096 quantiles lack 0.04 % of the variance.
  EXPECT_NEAR(std::sqrt(squares / n), 192.0, 5 * 192 / std::sqrt(2 * n) + 0.1);
}

}  // namespace
}  // namespace rangegrasp::sensing::internal
