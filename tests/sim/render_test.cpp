#include "sim/render.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "error_of.h"
#include "sim/scene_files.h"
#include "temp_folder.h"

namespace rangegrasp::sim {
namespace {

int Reds(const image::Image& image) {
  int reds = 0;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    reds += image.rgb[i] > 150 && image.rgb[i + 1] < 60 && image.rgb[i + 2] < 60;
  }
  return reds;
}

// A red ball.
ObjectModel Ball(const testing_support::TempFolder& folder, double radius_m) {
  return {"ball", folder.Write("ball.xml",
                               fmt::format("<mujoco><worldbody><body name='ball'><freejoint/><geom "
                                           "type='sphere' size='{}' rgba='1 0 0 1' mass='0.1'/>"
                                           "</body></worldbody></mujoco>",
                                           radius_m))};
}

TEST(Renderer, ShowsTheSceneAndItsObjects) {
  const testing_support::TempFolder folder;
  World world(samples::Tabletop(), {Ball(folder, 0.1)}, {});
  Renderer renderer(world, 160, 120);
  const image::Image plain = renderer.Render(world, "overview");
  EXPECT_EQ(plain.rgb.size(), 160u * 120u * 3u);
  EXPECT_GT(std::set<std::uint8_t>(plain.rgb.begin(), plain.rgb.end()).size(), 30u);
  EXPECT_EQ(renderer.Render(world, "overview").rgb, plain.rgb);

  world.PlaceObject(0, base::MakePose(Eigen::Matrix3d::Identity(), {0, 0, 0.2}));
  EXPECT_GT(Reds(renderer.Render(world, "overview")), Reds(plain) + 50);
}

// Millimetres in place of metres.
TEST(Renderer, AFreeViewFromTooFarIsRefused) {
  const testing_support::TempFolder folder;
  World world(samples::Tabletop(), {Ball(folder, 0.1)}, {});
  Renderer renderer(world, 16, 16);
  EXPECT_THAT(testing_support::ErrorOf([&] { renderer.Render(world, "0.5,0.5,500,0,0,0"); }),
              testing::HasSubstr("camera '0.5,0.5,500,0,0,0': is 500 m from the point"));
}

// A ball straight ahead of a free camera is in the middle of the picture. Rows count from the top.
TEST(Renderer, FreeViewLooksWhereItIsTold) {
  const testing_support::TempFolder folder;
  World world(samples::Tabletop(), {Ball(folder, 0.02)}, {});
  world.PlaceObject(0, base::MakePose(Eigen::Matrix3d::Identity(), {0, 0, 0.15}));
  Renderer renderer(world, 120, 120);
  const image::Image picture = renderer.Render(world, "0,-0.8,0.1,0,0,0.1");
  double row = 0.0, column = 0.0;
  int n = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) {
      const std::uint8_t* p = &picture.rgb[3 * (120 * y + x)];
      if (p[0] < 120 || p[1] > 60 || p[2] > 60) continue;
      row += y;
      column += x;
      ++n;
    }
  }
  ASSERT_GT(n, 3);
  EXPECT_NEAR(column / n, 60, 4);
  EXPECT_LT(row / n, 58);  // above the target point
}

TEST(Renderer, NamesTheCamerasThatExist) {
  World world(samples::Tabletop(), {}, {});
  Renderer renderer(world, 32, 32);
  const std::string error = testing_support::ErrorOf([&] { renderer.Render(world, "backyard"); });
  EXPECT_THAT(error, ::testing::HasSubstr("backyard"));
  EXPECT_THAT(error, ::testing::HasSubstr("overview"));
}

}  // namespace
}  // namespace rangegrasp::sim
