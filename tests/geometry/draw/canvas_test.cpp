#include "geometry/draw/canvas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 120;

// Looks from 2 m above the x-y plane, with x to the right and y upwards in the picture.
View FromAbove() { return {{0.0, 0.0, 2.0}, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, 0.6}; }

double PixelsPerMetre() { return 0.5 * kHeight / (2.0 * std::tan(0.3)); }

// The pixel coordinates of a point in the plane z = 0; pixel centres are at half integers.
Eigen::Vector2d Project(double x, double y) {
  return {0.5 * kWidth + x * PixelsPerMetre(), 0.5 * kHeight - y * PixelsPerMetre()};
}

Eigen::Vector3i Pixel(const image::Image& image, int x, int y) {
  const auto at = static_cast<std::size_t>((y * image.width + x) * 3);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

// Area and centroid of everything that is not white. The drawing is red, so each pixel is weighted
// by its difference from white in the green channel.
struct Blob {
  double area = 0.0;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
};
Blob NotWhite(const image::Image& image) {
  Blob blob;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double weight = (255.0 - Pixel(image, x, y).y()) / 255.0;
      blob.area += weight;
      blob.center += weight * Eigen::Vector2d(x + 0.5, y + 0.5);
    }
  }
  if (blob.area > 0.0) blob.center /= blob.area;
  return blob;
}

const Color kRed{1.0F, 0.0F, 0.0F, 1.0F};

Canvas Dot(const Eigen::Vector3d& p, const Color& color = kRed) {
  Canvas canvas;
  canvas.dots.push_back({{p}, color, 4.0F});
  return canvas;
}

TEST(Render, AnEmptyCanvasIsWhiteAndOfTheSizeAsked) {
  const auto image = Render({}, FromAbove(), kWidth, kHeight);
  EXPECT_EQ(image.width, kWidth);
  EXPECT_EQ(image.height, kHeight);
  EXPECT_EQ(image.rgb, std::vector<std::uint8_t>(kWidth * kHeight * 3, 255));
}

TEST(Render, ADotAppearsWhereThePinholePutsIt) {
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.3, 0.1}, {-0.4, 0.2}, {0.2, -0.3}}) {
    const Blob blob = NotWhite(Render(Dot({x, y, 0.0}), FromAbove(), kWidth, kHeight));
    EXPECT_NEAR(blob.area, 16.0, 8.0);
    // The rasterisation error is half a subpixel on either side.
    EXPECT_NEAR((blob.center - Project(x, y)).norm(), 0.0, 0.5) << x << " " << y;
  }
}

TEST(Render, ATriangleCoversItsProjection) {
  Canvas canvas;
  canvas.surfaces.push_back(
      {{{{-0.3, -0.2, 0.0}, {0.3, -0.2, 0.0}, {-0.3, 0.4, 0.0}}, {{0, 1, 2}}}, {1, 0, 0, 1}});
  const Blob blob = NotWhite(Render(canvas, FromAbove(), kWidth, kHeight));
  const double scale = PixelsPerMetre();
  const double perimeter = (0.6 + 0.6 + 0.6 * std::sqrt(2.0)) * scale;
  EXPECT_NEAR(blob.area, 0.5 * 0.6 * 0.6 * scale * scale, 0.5 * perimeter);  // half a pixel
  EXPECT_NEAR((blob.center - Project(-0.1, 0.0)).norm(), 0.0, 0.5);
}

TEST(Render, ALineJoinsItsPoints) {
  Canvas canvas;
  canvas.lines.push_back({{{-0.3, 0.0, 0.0}, {0.3, 0.0, 0.0}}, kRed, 2.0F});
  const auto image = Render(canvas, FromAbove(), kWidth, kHeight);
  for (const double x : {-0.29, -0.1, 0.0, 0.2, 0.29}) {
    EXPECT_LT(Pixel(image, static_cast<int>(Project(x, 0.0).x()), kHeight / 2).y(), 160) << x;
  }
  EXPECT_EQ(Pixel(image, static_cast<int>(Project(0.4, 0.0).x()), kHeight / 2).y(), 255);
}

TEST(Render, WhatIsNearerHidesWhatIsBehind) {
  for (const bool red_first : {true, false}) {
    Canvas canvas;
    const Canvas::Dots red{{{0.0, 0.0, 0.5}}, kRed, 6.0F};
    const Canvas::Dots blue{{{0.0, 0.0, 0.0}}, {0.0F, 0.0F, 1.0F, 1.0F}, 6.0F};
    canvas.dots = red_first ? std::vector{red, blue} : std::vector{blue, red};
    const auto image = Render(canvas, FromAbove(), kWidth, kHeight);
    EXPECT_EQ(Pixel(image, kWidth / 2, kHeight / 2), Eigen::Vector3i(255, 0, 0)) << red_first;
  }
}

TEST(Render, WhatIsBehindTheCameraIsNotSeen) {
  EXPECT_EQ(NotWhite(Render(Dot({0.0, 0.0, 3.0}), FromAbove(), kWidth, kHeight)).area, 0.0);
}

TEST(Render, TheSameCanvasGivesTheSameBytes) {
  const Canvas canvas = Dot({0.1, 0.1, 0.0});
  EXPECT_EQ(Render(canvas, FromAbove(), kWidth, kHeight).rgb,
            Render(canvas, FromAbove(), kWidth, kHeight).rgb);
}

TEST(Render, ASizeMustBePositive) {
  for (const auto& [width, height] : {std::pair{0, 10}, {10, 0}, {-1, 10}, {10, -5}}) {
    EXPECT_THROW(Render({}, FromAbove(), width, height), std::invalid_argument);
  }
  EXPECT_EQ(Render({}, FromAbove(), 1, 1).rgb.size(), 3u);
}

TEST(Render, WhatIsSeenThroughDoesNotHide) {
  Canvas canvas;
  const auto triangle = [&](double z) {
    geometry::TriangleMesh mesh;
    mesh.vertices = {{-1.0, -1.0, z}, {1.0, -1.0, z}, {0.0, 1.0, z}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
  };
  canvas.surfaces.push_back({triangle(0.5), Color(1.0F, 0.0F, 0.0F, 0.5F)});
  canvas.surfaces.push_back({triangle(0.0), Color(0.0F, 0.0F, 1.0F, 1.0F)});
  const auto middle = Pixel(Render(canvas, FromAbove(), kWidth, kHeight), kWidth / 2, kHeight / 2);
  EXPECT_GT(middle.z(), middle.x());  // the blue triangle behind was drawn
}

TEST(Render, ShadesDoNotDependOnWinding) {
  Canvas canvas;
  geometry::TriangleMesh mesh;
  mesh.vertices = {{-0.3, -0.3, 0.0}, {0.3, -0.3, 0.1}, {0.0, 0.3, 0.2}};
  mesh.triangles = {{0, 1, 2}};
  canvas.surfaces.push_back({mesh, kRed});
  Canvas turned = canvas;
  turned.surfaces[0].mesh.triangles = {{0, 2, 1}};
  const auto image = Render(canvas, FromAbove(), kWidth, kHeight);
  EXPECT_EQ(Pixel(image, kWidth / 2, kHeight / 2),
            Pixel(Render(turned, FromAbove(), kWidth, kHeight), kWidth / 2, kHeight / 2));
}

TEST(PaletteColor, TheFirstDozenDiffer) {
  // Steps of the golden angle leave at least 0.0557 of the circle between any two of 12 hues. This
  // is a third of a channel's ramp of 0.7, and two channels may share it.
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((PaletteColor(i) - PaletteColor(j)).norm(), 0.15F) << i << " " << j;
    }
  }
}

TEST(PaletteColor, ColoursAreValidAndFarFromTheirNeighbours) {
  for (std::size_t i = 0; i < 200; ++i) {
    const Color color = PaletteColor(i);
    EXPECT_GE(color.minCoeff(), 0.0F);
    EXPECT_LE(color.maxCoeff(), 1.0F);
    EXPECT_GT((color - PaletteColor(i + 1)).norm(), 0.3F) << i;
    EXPECT_GT((color - PaletteColor(i + 2)).norm(), 0.2F) << i;
  }
}

}  // namespace
}  // namespace rangegrasp::draw
