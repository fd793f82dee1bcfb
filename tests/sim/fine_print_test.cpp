#include "sim/internal/fine_print.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace rangegrasp::sim::internal {
namespace {

constexpr double kTexel_mm = 0.45;  // each becomes three texels of print

/// A white label, with a red square in its middle if `marked`.
image::Image Label(int size, bool marked) {
  image::Image label{size, size, {}};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const bool red =
          marked && std::abs(2 * x + 1 - size) < size / 4 && std::abs(2 * y + 1 - size) < size / 4;
      for (const int level : {230, red ? 20 : 230, red ? 20 : 230}) {
        label.rgb.push_back(static_cast<std::uint8_t>(level));
      }
    }
  }
  return label;
}

/// Share of texels whose green channel differs by more than 20 levels from `green`.
double ShareOff(const image::Image& texture, int green) {
  int off = 0;
  for (std::size_t i = 1; i < texture.rgb.size(); i += 3) {
    off += std::abs(texture.rgb[i] - green) > 20;
  }
  return 3.0 * off / static_cast<double>(texture.rgb.size());
}

TEST(FinePrint, LeavesTheLabelsOwnMarksWhereTheyAre) {
  const image::Image label = Label(120, true);
  const image::Image printed = WithFinePrint(label, kTexel_mm, FinePrint{}, 1);
  const int factor = printed.width / label.width;
  ASSERT_EQ(factor, 3);
  for (int y = 0; y < label.height; ++y) {
    for (int x = 0; x < label.width; ++x) {  // the middle one of three is the original texel
      const auto from = static_cast<std::size_t>(3 * (y * label.width + x) + 1);
      const auto to =
          static_cast<std::size_t>(3 * ((factor * y + 1) * printed.width + factor * x + 1) + 1);
      EXPECT_NEAR(printed.rgb[to], label.rgb[from], 1);
    }
  }
}

// Letters and bars cover a third to a half of their blocks with ink.
TEST(FinePrint, FillsTheWantedShareOfAnEmptyLabel) {
  const image::Image label = Label(400, false);
  for (const double coverage : {0.1, 0.3}) {
    const double inked = ShareOff(WithFinePrint(label, kTexel_mm, {coverage, 0, 0.0}, 2), 230);
    EXPECT_GT(inked, 0.2 * coverage);
    EXPECT_LT(inked, 0.8 * coverage + 0.02);  // the last block may exceed it
  }
}

TEST(FinePrint, LeavesALabelThatIsFullAlone) {
  image::Image full = Label(200, false);
  for (std::size_t i = 0; i < full.rgb.size(); ++i) {  // stripes of 4 texels
    if (i / 3 % 200 / 4 % 2 == 0) full.rgb[i] = 30;
  }
  const image::Image plain = WithFinePrint(full, kTexel_mm, FinePrint{}, 3);
  EXPECT_EQ(WithFinePrint(full, kTexel_mm, {0.3, 0, 0.0}, 3).rgb, plain.rgb);
}

TEST(FinePrint, IsTheSameForOneSeed) {
  const image::Image label = Label(200, true);
  const FinePrint print{0.3, 2, 2.5};
  const image::Image once = WithFinePrint(label, kTexel_mm, print, 4);
  EXPECT_EQ(once.rgb, WithFinePrint(label, kTexel_mm, print, 4).rgb);
  EXPECT_NE(once.rgb, WithFinePrint(label, kTexel_mm, print, 5).rgb);
}

}  // namespace
}  // namespace rangegrasp::sim::internal
