#include "geometry/view_images.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "temp_folder.h"

namespace rangegrasp::geometry {
namespace {

using Eigen::Vector3d;

constexpr int kColumns = 40, kRows = 30;

/// A wall 0.8 m in front of a camera, with a corner that the camera did not measure.
View CameraView() {
  View view;
  view.X_CV = base::MakePose(Eigen::AngleAxisd(2.0, Vector3d(1, 2, 3).normalized()).matrix(),
                             {0.3, -0.2, 0.5});
  view.image.profiles = kRows;
  view.image.samples = kColumns;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      view.image.points_C.push_back(
          view.X_CV * (0.8 * Vector3d((column - 19.5) / 50.0, (row - 14.0) / 52.0, 1.0)));
      view.colors.push_back({static_cast<std::uint8_t>(column), static_cast<std::uint8_t>(row), 7});
    }
  }
  view.image.points_C.front().setConstant(std::numeric_limits<double>::quiet_NaN());
  return view;
}

TEST(ViewImages, OfACameraHaveItsLensDepthsAndColors) {
  const auto images = ImagesOf(CameraView());
  ASSERT_TRUE(images);
  EXPECT_NEAR(images->fx, 50.0, 1e-6);
  EXPECT_NEAR(images->fy, 52.0, 1e-6);
  EXPECT_NEAR(images->cx, 19.5, 1e-6);
  EXPECT_NEAR(images->cy, 14.0, 1e-6);
  EXPECT_EQ(images->depth.width, kColumns);
  EXPECT_EQ(images->depth.height, kRows);
  EXPECT_EQ(images->depth.grey[0], 0);
  EXPECT_EQ(images->depth.grey[1], 8000);
  EXPECT_EQ(images->color.At(5, 6)[0], 5);
  EXPECT_EQ(images->color.At(5, 6)[1], 6);
}

TEST(ViewImages, OfASensorThatTurnsThereAreNone) {
  View view = CameraView();
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    const double pan = 0.02 * static_cast<double>(i / kColumns);
    view.image.points_C[i] =
        view.X_CV *
        Vector3d(std::sin(pan), 0.01 * static_cast<double>(i % kColumns), std::cos(pan));
  }
  EXPECT_FALSE(ImagesOf(view));
  const testing_support::TempFolder folder;
  EXPECT_FALSE(WriteImages(view, folder / "", "a"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a_depth.png"));
}

TEST(ViewImages, AreWrittenUnderNamesOfTheirOwn) {
  const testing_support::TempFolder folder;
  View view = CameraView();
  const auto written = WriteImages(view, folder / "", "a");
  ASSERT_TRUE(written);
  EXPECT_EQ(image::ReadPng<image::Grey16>(folder / written->depth).grey,
            written->images.depth.grey);
  EXPECT_EQ(image::ReadPng<image::Image>(folder / written->color).rgb, written->images.color.rgb);
  view.colors.clear();
  EXPECT_EQ(WriteImages(view, folder / "", "b")->color, "");
}

}  // namespace
}  // namespace rangegrasp::geometry
