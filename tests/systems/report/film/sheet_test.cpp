#include "report/film/internal/sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

image::Image Plain(int width, int height, std::uint8_t value) {
  image::Image picture = Blank(width, height);
  std::ranges::fill(picture.rgb, value);
  return picture;
}

TEST(SheetOf, PutsPicturesInRowsWithACaptionBelowEach) {
  const image::Image sheet = SheetOf(
      {{Plain(80, 60, 10), "one"}, {Plain(160, 120, 20), "two"}, {Plain(80, 60, 40), "three"}}, 2,
      40);
  EXPECT_EQ(sheet.width, 80);
  const int tile = sheet.height / 2;
  EXPECT_GT(tile, 30);
  EXPECT_EQ(*sheet.At(20, 15), 10);
  EXPECT_EQ(*sheet.At(60, 15), 20);
  EXPECT_EQ(*sheet.At(20, tile + 15), 40);
  EXPECT_EQ(*sheet.At(60, tile + 15), 255);  // empty
  const auto has_ink = [&](int left) {
    for (int y = 31; y < tile; ++y) {
      for (int x = left; x < left + 40; ++x) {
        if (*sheet.At(x, y) < 128) return true;
      }
    }
    return false;
  };
  EXPECT_TRUE(has_ink(0));
  EXPECT_TRUE(has_ink(40));
}

TEST(Fitted, KeepsAPicturesShape) {
  const image::Image fitted = Fitted(Plain(100, 50, 0), 40, 40);
  EXPECT_EQ(fitted.width, 40);
  EXPECT_EQ(fitted.height, 40);
  EXPECT_EQ(*fitted.At(20, 5), 255);
  EXPECT_EQ(*fitted.At(20, 20), 0);
}

TEST(Paste, CutsOffWhatJutsOut) {
  image::Image picture = Blank(10, 10);
  Paste(Plain(8, 8, 0), 6, -4, picture);
  EXPECT_EQ(*picture.At(9, 3), 0);
  EXPECT_EQ(*picture.At(9, 4), 255);
  EXPECT_EQ(*picture.At(5, 0), 255);
  Paste(Plain(8, 8, 0), 40, 40, picture);  // entirely outside
}

// A value in the middle of the axis range is drawn at half the height.
TEST(DrawStrips, AValueStandsWhereItsAxisSays) {
  const Color red(1.0F, 0.0F, 0.0F, 1.0F);
  const image::Image chart = DrawStrips(
      {0.0, 10.0}, {{.label = "", .y = {5.0, 5.0}, .at_least = 10.0, .color = red}}, {}, 400, 200);
  std::vector<int> red_rows;
  for (int y = 0; y < chart.height; ++y) {
    const std::uint8_t* p = chart.At(200, y);
    if (p[0] > 200 && p[1] < 60 && p[2] < 60) red_rows.push_back(y);
  }
  ASSERT_FALSE(red_rows.empty());
  // The plot area is from 24 px to 6 + 22 px above the lower edge.
  EXPECT_NEAR(red_rows[red_rows.size() / 2], (24 + 200 - 28) / 2, 2);
}

}  // namespace
}  // namespace rangegrasp::draw
