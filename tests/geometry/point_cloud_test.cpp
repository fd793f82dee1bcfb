#include "geometry/point_cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/ray_caster.h"

namespace rangegrasp::geometry {
namespace {

TEST(PointCloud, SelectKeepsTheOrderOfTheIndices) {
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}};
  const Indices indices = {2, 0, 2};
  EXPECT_EQ(Select(points, indices), (Points{points[2], points[0], points[2]}));
}

TEST(PointCloud, CentroidIsTheMean) {
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 2.0, -4.0}};
  EXPECT_EQ(Centroid(points), Eigen::Vector3d(0.5, 1.0, -2.0));
  EXPECT_THROW(Centroid(Points{}), std::invalid_argument);
}

// IEC 61966-2-1: level 188 is half the linear intensity; level 10 is in the linear part.
TEST(Color, LightIsThatOfTheStandard) {
  const Eigen::Vector3d light = LightOf({188, 10, 255});
  EXPECT_NEAR(light.x(), 0.5029, 1e-4);
  EXPECT_NEAR(light.y(), 10.0 / 255.0 / 12.92, 1e-12);
  EXPECT_NEAR(light.z(), 1.0, 1e-12);
}

TEST(Color, EveryLevelSurvivesTheWayThereAndBack) {
  for (int level = 0; level < 256; ++level) {
    const auto byte = static_cast<std::uint8_t>(level);
    EXPECT_EQ(ColorOf(LightOf({byte, byte, byte})), (Rgb{byte, byte, byte}));
  }
  EXPECT_EQ(ColorOf({2.0, -1.0, 0.5}), (Rgb{255, 0, 188}));
}

TEST(Color, IsTheRoundedOneOfTheStandardForAnyLight) {
  for (int i = 0; i <= 100'003; ++i) {
    const double light = i / 100'003.0;
    const double share =
        light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
    const auto level = static_cast<std::uint8_t>(std::lround(255.0 * share));
    ASSERT_EQ(ColorOf({light, light, light}), (Rgb{level, level, level})) << light;
  }
}

// Two triangles of a square. The first one is textured with four texels.
TEST(MeshColors, ThePrintGoesBeforeThePlainColor) {
  MeshColors colors;
  EXPECT_FALSE(colors.At({}));
  colors.plain = {{9, 9, 9}, {8, 8, 8}};
  auto print = std::make_shared<Print>();
  print->width = print->height = 2;
  print->texels = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
  colors.print = print;
  const Eigen::Vector2f none = Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
  colors.uv = {{Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 0), Eigen::Vector2f(0, 1)},
               {none, none, none}};
  const auto at = [&](std::uint32_t triangle, float second, float third) {
    Hit hit;
    hit.triangle = triangle;
    hit.second = second;
    hit.third = third;
    return *colors.At(hit);
  };
  EXPECT_EQ(at(0, 0.1f, 0.1f), (Rgb{1, 0, 0}));
  EXPECT_EQ(at(0, 0.8f, 0.1f), (Rgb{2, 0, 0}));
  EXPECT_EQ(at(0, 0.1f, 0.8f), (Rgb{3, 0, 0}));
  EXPECT_EQ(at(1, 0.1f, 0.1f), (Rgb{8, 8, 8}));
  colors.uv[0] = {Eigen::Vector2f(1.6f, 1.6f), Eigen::Vector2f(1.6f, 1.6f),
                  Eigen::Vector2f(1.6f, 1.6f)};
  EXPECT_EQ(at(0, 0.3f, 0.3f), (Rgb{4, 0, 0}));  // the texture repeats
}

}  // namespace
}  // namespace rangegrasp::geometry
