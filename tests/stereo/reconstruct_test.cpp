#include "stereo/reconstruct.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/quantile.h"
#include "synthetic_pair.h"

namespace rangegrasp::stereo {
namespace {

using testing_support::Meet;
using testing_support::Picture;
using testing_support::SyntheticCalibration;
using testing_support::SyntheticScene;
using testing_support::TwoBoxes;

constexpr double kNoiseLevels = 2.0;

struct Pair {
  StereoCalibration calibration = SyntheticCalibration();
  SyntheticScene scene = TwoBoxes();
  image::Image left = Picture(scene, calibration.camera, calibration.X_WL, kNoiseLevels, 1);
  image::Image right = Picture(scene, calibration.camera, calibration.X_WR, kNoiseLevels, 2);
  Rectifier rectifier{calibration};
};

const Pair& ThePair() {
  static const Pair pair;
  return pair;
}

// The small camera's pixels are eight times as large as those of the one that defaults are for.
ReconstructOptions SmallCamera(MatchMethod method) {
  ReconstructOptions options;
  options.match.method = method;
  options.match.shrink = 1;
  options.match.block_window_px = 11;
  options.match.min_patch_px = 40;
  options.step_px = 2;
  options.near_m = 0.35;
  options.far_m = 0.9;
  options.table_W = geometry::Plane{};
  return options;
}

// Of the pixels that show a box: how many there are, and the errors of those with a disparity.
struct Errors {
  int pixels = 0;
  std::vector<double> errors_px;
};
Errors ErrorsOn(int box, const Reconstruction& made) {
  const Pair& pair = ThePair();
  const RectifiedCameras& cameras = pair.rectifier.cameras();
  Errors errors;
  for (int y = 0; y < cameras.height; ++y) {
    for (int x = 0; x < cameras.width; ++x) {
      const Eigen::Vector3d ray_W =
          cameras.X_WS.rotation() *
          Eigen::Vector3d((x - cameras.cx) / cameras.f, (y - cameras.cy) / cameras.f, 1.0);
      const auto hit = Meet(pair.scene, cameras.X_WS.translation(), ray_W);
      if (hit.box != box) continue;
      ++errors.pixels;
      const float disparity = made.disparity.grey[static_cast<std::size_t>(y * cameras.width + x)];
      if (std::isnan(disparity)) continue;
      errors.errors_px.push_back(std::abs(disparity - cameras.DisparityAt(hit.along)));
    }
  }
  return errors;
}

class BothMethods : public ::testing::TestWithParam<MatchMethod> {};

TEST_P(BothMethods, FindTheDisparityOfPrintToAFractionOfAPixel) {
  const Pair& pair = ThePair();
  const Reconstruction made =
      Reconstruct(pair.left, pair.right, pair.rectifier, SmallCamera(GetParam()));
  Errors errors = ErrorsOn(0, made);
  ASSERT_GT(errors.pixels, 2000);
  EXPECT_GT(static_cast<double>(errors.errors_px.size()), 0.7 * errors.pixels);
  // A sixteenth is the matchers' own step; noise of 2 levels in 100 adds about as much.
  EXPECT_LT(core::MedianOf(errors.errors_px), 0.15);
}

// Half of a normal distribution lies within 0.674 deviations, where the density of the absolute
// value is 0.636: the median of n independent errors has the standard error 1 / (2 0.636 sqrt(n)).
// Samples that share a matching window share its error, so that n is a window's share of them. Of
// an error that is not more than its sample states, the median is below this but once in 700 times.
double GreatestMedian(std::size_t samples, const ReconstructOptions& options) {
  const int window_px = options.match.method == MatchMethod::kBlock
                            ? options.match.block_window_px
                            : options.match.semi_global_window_px;
  const double in_window = std::pow(static_cast<double>(window_px) / options.step_px, 2);
  const double independent = static_cast<double>(samples) / in_window;
  return 0.674 + 3.0 / (2.0 * 0.636 * std::sqrt(independent));
}

TEST_P(BothMethods, PutPointsWhereTheSurfacesAre) {
  const Pair& pair = ThePair();
  const Reconstruction made =
      Reconstruct(pair.left, pair.right, pair.rectifier, SmallCamera(GetParam()));
  const auto& view = made.view;
  ASSERT_EQ(view.image.points_C.size(), view.noise_m.size());
  ASSERT_EQ(view.image.points_C.size(), made.left_pixel.size());
  std::vector<double> errors_in_noise;
  const Eigen::Vector3d origin_W = view.image.origins_C.front();
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p_W = view.image.points_C[i];
    if (!p_W.allFinite() || view.noise_m[i] == 0.0F) continue;
    const Eigen::Vector3d ray_W = p_W - origin_W;
    const auto hit = Meet(pair.scene, origin_W, ray_W);
    if (hit.box != 0) continue;
    errors_in_noise.push_back(std::abs(hit.along - 1.0) * ray_W.norm() /
                              static_cast<double>(view.noise_m[i]));
  }
  ASSERT_GT(errors_in_noise.size(), 500U);
  EXPECT_LT(core::MedianOf(errors_in_noise),
            GreatestMedian(errors_in_noise.size(), SmallCamera(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Match, BothMethods,
                         ::testing::Values(MatchMethod::kSemiGlobal, MatchMethod::kBlock));

TEST(Reconstruct, RemovedPixelsLieOnTheTableAndNoneOfThemIsMatched) {
  const Pair& pair = ThePair();
  ReconstructOptions options = SmallCamera(MatchMethod::kSemiGlobal);
  const Reconstruction made = Reconstruct(pair.left, pair.right, pair.rectifier, options);
  for (std::size_t i = 0; i < made.kept.grey.size(); ++i) {
    if (made.kept.grey[i] == 0) {
      EXPECT_TRUE(std::isnan(made.disparity.grey[i]));
    }
  }
  int on_table = 0;
  for (std::size_t i = 0; i < made.view.noise_m.size(); ++i) {
    if (made.view.noise_m[i] != 0.0F) continue;
    EXPECT_NEAR(made.view.image.points_C[i].z(), 0.0, 1e-12);
    ++on_table;
  }
  EXPECT_GT(on_table, 5000);

  options.table_W.reset();
  const Reconstruction without = Reconstruct(pair.left, pair.right, pair.rectifier, options);
  EXPECT_EQ(std::count(without.view.noise_m.begin(), without.view.noise_m.end(), 0.0F), 0);
}

TEST(Reconstruct, GreyIsNotReconstructedByBlocksAsPrintIs) {
  const Pair& pair = ThePair();
  const Reconstruction made =
      Reconstruct(pair.left, pair.right, pair.rectifier, SmallCamera(MatchMethod::kBlock));
  const Errors print = ErrorsOn(0, made), grey = ErrorsOn(1, made);
  EXPECT_LT(static_cast<double>(grey.errors_px.size()) / grey.pixels,
            0.8 * static_cast<double>(print.errors_px.size()) / print.pixels);
}

TEST(Reconstruct, TellsWhichPixelOfTheLeftPictureASampleComesFrom) {
  const Pair& pair = ThePair();
  const Reconstruction made =
      Reconstruct(pair.left, pair.right, pair.rectifier, SmallCamera(MatchMethod::kSemiGlobal));
  const core::Pose X_LW = pair.calibration.X_WL.inverse();
  for (std::size_t i = 0; i < made.left_pixel.size(); ++i) {
    const Eigen::Vector3d& p_W = made.view.image.points_C[i];
    if (!p_W.allFinite()) continue;
    const Eigen::Vector2d pixel = Project(pair.calibration.camera, X_LW * p_W);
    // Kept in single precision: 400 px to 3e-5.
    EXPECT_LT((pixel - made.left_pixel[i].cast<double>()).norm(), 1e-4);
  }
}

TEST(Reconstruct, SamePicturesGiveTheSameCloud) {
  const Pair& pair = ThePair();
  const auto options = SmallCamera(MatchMethod::kSemiGlobal);
  const Reconstruction a = Reconstruct(pair.left, pair.right, pair.rectifier, options);
  const Reconstruction b = Reconstruct(pair.left, pair.right, pair.rectifier, options);
  ASSERT_EQ(a.disparity.grey.size(), b.disparity.grey.size());
  for (std::size_t i = 0; i < a.disparity.grey.size(); ++i) {
    const float da = a.disparity.grey[i], db = b.disparity.grey[i];
    EXPECT_TRUE(da == db || (std::isnan(da) && std::isnan(db)));
  }
}

TEST(Reconstruct, APictureOfTheTableAloneHasNoPointAboveIt) {
  const StereoCalibration calibration = SyntheticCalibration();
  const SyntheticScene empty;
  const Reconstruction made =
      Reconstruct(Picture(empty, calibration.camera, calibration.X_WL, kNoiseLevels, 3),
                  Picture(empty, calibration.camera, calibration.X_WR, kNoiseLevels, 4),
                  Rectifier(calibration), SmallCamera(MatchMethod::kSemiGlobal));
  for (const Eigen::Vector3d& p_W : made.view.image.points_C) {
    if (p_W.allFinite()) {
      EXPECT_NEAR(p_W.z(), 0.0, 1e-12);
    }
  }
}

TEST(WithoutBlue, RemovesBlueInLightAndShadowAndKeepsGreyAndBlackOut) {
  image::Image picture{
      6, 1, {40, 60, 150, 10, 15, 38, 200, 200, 210, 200, 40, 40, 20, 20, 21, 0, 0, 0}};
  const Mask mask = WithoutBlue(picture, 0.15, 12, 1);
  EXPECT_EQ(mask.grey, (std::vector<std::uint8_t>{0, 0, 255, 255, 255, 0}));
}

TEST(Match, RefusesOptionsThatAreOutOfRange) {
  const image::Grey8 grey{64, 64, std::vector<std::uint8_t>(64 * 64, 100)};
  const image::Image whole{64, 64, std::vector<std::uint8_t>(3 * 64 * 64, 100)};
  const Mask all{64, 64, std::vector<std::uint8_t>(64 * 64, 255)};
  MatchOptions options;
  options.block_window_px = 20;
  EXPECT_THROW(Match(grey, grey, all, whole, 1.0, 17.0, options), std::invalid_argument);
  options = {};
  EXPECT_THROW(Match(grey, grey, all, whole, 17.0, 1.0, options), std::invalid_argument);
  const Mask small{32, 64, std::vector<std::uint8_t>(32 * 64, 255)};
  EXPECT_THROW(Match(grey, grey, small, whole, 1.0, 17.0, options), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::stereo
