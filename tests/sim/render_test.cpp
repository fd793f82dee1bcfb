#include "sim/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "base/error.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

int Reds(const image::Image& image) {
  int reds = 0;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    reds += image.rgb[i] > 150 && image.rgb[i + 1] < 60 && image.rgb[i + 2] < 60;
  }
  return reds;
}

TEST(Renderer, ShowsTheSceneAndWhatIsDrawnOverIt) {
  World world(samples::Tabletop(), {samples::RepositoryObject("dextrose")}, {});
  Renderer renderer(world, 160, 120);
  const image::Image plain = renderer.Render(world, "overview");
  EXPECT_EQ(plain.rgb.size(), 160u * 120u * 3u);
  EXPECT_GT(std::set<std::uint8_t>(plain.rgb.begin(), plain.rgb.end()).size(), 30u);
  EXPECT_EQ(renderer.Render(world, "overview").rgb, plain.rgb);

  Overlay overlay;
  overlay.dots.push_back({{0, 0, 0.2}, {1, 0, 0, 1}, 0.05});
  overlay.segments.push_back({{0.2, -0.2, 0.1}, {0.2, 0.2, 0.1}, {1, 0, 0, 1}, 0.02});
  EXPECT_GT(Reds(renderer.Render(world, "overview", overlay)), Reds(plain) + 50);
}

// A dot straight ahead of a free camera is in the middle of the picture; rows count from the top.
TEST(Renderer, FreeViewLooksWhereItIsTold) {
  World world(samples::Tabletop(), {}, {});
  Renderer renderer(world, 120, 120);
  Overlay overlay;
  overlay.dots.push_back({{0, 0, 0.15}, {1, 0, 0, 1}, 0.02});
  const image::Image picture = renderer.Render(world, "0,-0.8,0.1,0,0,0.1", overlay);
  double row = 0.0, column = 0.0;
  int n = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) {
      const std::uint8_t* p = &picture.rgb[static_cast<std::size_t>(3 * (120 * y + x))];
      if (p[0] < 120 || p[1] > 60 || p[2] > 60) continue;
      row += y;
      column += x;
      ++n;
    }
  }
  ASSERT_GT(n, 3);
  EXPECT_NEAR(column / n, 60, 4);
  EXPECT_LT(row / n, 58);  // above the point that is looked at
}

TEST(Renderer, NamesTheCamerasThatExist) {
  World world(samples::Tabletop(), {}, {});
  Renderer renderer(world, 32, 32);
  try {
    renderer.Render(world, "backyard");
    FAIL();
  } catch (const base::InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("backyard"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("overview"));
  }
}

}  // namespace
}  // namespace rangegrasp::sim
