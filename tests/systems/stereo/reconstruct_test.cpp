#include "stereo/reconstruct.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/rng.h"
#include "base/statistics.h"
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

// The pixels of the small camera are eight times as large as those that the defaults assume.
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

Reconstruction Made(const ReconstructOptions& options) {
  return Reconstruct(ThePair().left, ThePair().right, ThePair().rectifier, options);
}

// The number of pixels that show a box, and the errors of those that have a disparity.
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
  const Errors errors = ErrorsOn(0, Made(SmallCamera(GetParam())));
  ASSERT_GT(errors.pixels, 2000);
  EXPECT_GT(static_cast<double>(errors.errors_px.size()), 0.7 * errors.pixels);
  // The matchers' resolution is a sixteenth. Noise of 2 levels in 100 adds about as much.
  EXPECT_LT(base::MedianOf(errors.errors_px), 0.15);
}

// An upper bound for the median of the errors, in units of the stated noise. Half of a normal
// distribution lies within 0.674 standard deviations, where the density of the absolute value is
// 0.636. The median of n independent errors has the standard error 1 / (2 0.636 sqrt(n)). Samples
// in the same matching window share its error, so n is the number of samples divided by those per
// window. If the errors are no larger than stated, the median exceeds the bound once in 700 times.
double GreatestMedian(std::size_t samples, const ReconstructOptions& options) {
  const int window_px = options.match.method == MatchMethod::kBlock
                            ? options.match.block_window_px
                            : options.match.semi_global_window_px;
  const double in_window = std::pow(static_cast<double>(window_px) / options.step_px, 2);
  const double independent = static_cast<double>(samples) / in_window;
  return 0.674 + 3.0 / (2.0 * 0.636 * std::sqrt(independent));
}

TEST_P(BothMethods, PutPointsWhereTheSurfacesAre) {
  const Reconstruction made = Made(SmallCamera(GetParam()));
  const auto& view = made.view;
  ASSERT_EQ(view.image.points_C.size(), view.noise_m.size());
  ASSERT_EQ(view.image.points_C.size(), made.left_pixel.size());
  std::vector<double> errors_in_noise;
  const Eigen::Vector3d origin_W = view.image.origins_C.front();
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p_W = view.image.points_C[i];
    if (!p_W.allFinite() || view.noise_m[i] == 0.0F) continue;
    const Eigen::Vector3d ray_W = p_W - origin_W;
    const auto hit = Meet(ThePair().scene, origin_W, ray_W);
    if (hit.box != 0) continue;
    errors_in_noise.push_back(std::abs(hit.along - 1.0) * ray_W.norm() /
                              static_cast<double>(view.noise_m[i]));
  }
  ASSERT_GT(errors_in_noise.size(), 500U);
  EXPECT_LT(base::MedianOf(errors_in_noise),
            GreatestMedian(errors_in_noise.size(), SmallCamera(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Match, BothMethods,
                         ::testing::Values(MatchMethod::kSemiGlobal, MatchMethod::kBlock));

TEST(Reconstruct, RemovedPixelsLieOnTheTableAndNoneOfThemIsMatched) {
  ReconstructOptions options = SmallCamera(MatchMethod::kSemiGlobal);
  const Reconstruction made = Made(options);
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
  EXPECT_EQ(std::ranges::count(Made(options).view.noise_m, 0.0F), 0);
}

TEST(Reconstruct, GreyIsNotReconstructedByBlocksAsPrintIs) {
  const Reconstruction made = Made(SmallCamera(MatchMethod::kBlock));
  const Errors print = ErrorsOn(0, made), grey = ErrorsOn(1, made);
  EXPECT_LT(static_cast<double>(grey.errors_px.size()) / grey.pixels,
            0.8 * static_cast<double>(print.errors_px.size()) / print.pixels);
}

TEST(Reconstruct, TellsWhichPixelOfTheLeftPictureASampleComesFrom) {
  const Pair& pair = ThePair();
  const Reconstruction made = Made(SmallCamera(MatchMethod::kSemiGlobal));
  const base::Pose X_LW = pair.calibration.X_WL.inverse();
  int finite = 0;
  for (std::size_t i = 0; i < made.left_pixel.size(); ++i) {
    const Eigen::Vector3d& p_W = made.view.image.points_C[i];
    if (!p_W.allFinite()) continue;
    ++finite;
    const Eigen::Vector2d pixel = Project(pair.calibration.camera, X_LW * p_W);
    // Pixels are kept in single precision: 400 px are good to 3e-5.
    EXPECT_LT((pixel - made.left_pixel[i].cast<double>()).norm(), 1e-4);
  }
  EXPECT_GT(finite, 5000);
}

TEST(Reconstruct, WithoutTheCheckOfBothWaysMorePixelsMatch) {
  ReconstructOptions options = SmallCamera(MatchMethod::kSemiGlobal);
  const auto matched = [&] {
    const auto& grey = Made(options).disparity.grey;
    return std::ranges::count_if(grey, [](float disparity) { return !std::isnan(disparity); });
  };
  const auto checked = matched();
  options.match.max_left_right_px = -1;
  EXPECT_GT(matched(), checked);
}

TEST(Reconstruct, SamePicturesGiveTheSameCloud) {
  const auto options = SmallCamera(MatchMethod::kSemiGlobal);
  const Reconstruction a = Made(options), b = Made(options);
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

TEST(Reconstruct, MakesNoPointOutsideOfTheVolume) {
  ReconstructOptions options = SmallCamera(MatchMethod::kSemiGlobal);
  const auto made_points = [&] {
    const auto made = Made(options);
    std::vector<std::pair<Eigen::Vector3d, double>> points;
    for (std::size_t i = 0; i < made.view.noise_m.size(); ++i) {
      if (made.view.noise_m[i] > 0.0F) {  // not placed on the table by color
        points.emplace_back(made.view.image.points_C[i], made.view.noise_m[i]);
      }
    }
    return points;
  };
  const std::size_t without = made_points().size();
  // The volume holds half of the printed box and nothing of the other one.
  options.volume = {base::MakePose(Eigen::Matrix3d::Identity(), {0.0, -0.11, 0.0}), 0.045, 0.2};
  const auto within = made_points();
  EXPECT_GT(within.size(), 300U);
  EXPECT_LT(within.size(), without / 2);
  for (const auto& [p_W, noise_m] : within) {
    const Eigen::Vector3d p_V = options.volume->X_WV.inverse() * p_W;
    // A sample's ray goes through its middle, half a sample (1 mm) from the rays of its pixels.
    EXPECT_LT(p_V.head<2>().norm(), options.volume->radius_m + 3.0 * noise_m + 0.001);
    EXPECT_GT(p_V.z(), -3.0 * noise_m - 0.001);
  }
  options.volume->X_WV = base::MakePose(Eigen::Matrix3d::Identity(), {0.0, 3.0, 0.0});
  EXPECT_THROW(made_points(), base::InputError);
}

TEST(Reconstruct, BluePrintOnABoxIsNoTable) {
  const Pair& pair = ThePair();
  image::Image left = pair.left;
  // A blue mark of 12 x 6 pixels in the middle of the printed box's top.
  const Eigen::Vector2d middle =
      Project(pair.calibration.camera,
              pair.calibration.X_WL.inverse() * Eigen::Vector3d(0.0, -0.065, 0.09));
  const int x0 = static_cast<int>(middle.x()) - 6, y0 = static_cast<int>(middle.y()) - 3;
  for (int y = y0; y < y0 + 6; ++y) {
    for (int x = x0; x < x0 + 12; ++x) {
      std::uint8_t* pixel = left.rgb.data() + 3 * (y * left.width + x);
      pixel[0] = 40;
      pixel[1] = 60;
      pixel[2] = 150;
    }
  }
  ReconstructOptions options = SmallCamera(MatchMethod::kSemiGlobal);
  const auto table_samples_in_it = [&] {
    const auto made = Reconstruct(left, pair.right, pair.rectifier, options);
    int count = 0;
    for (std::size_t i = 0; i < made.left_pixel.size(); ++i) {
      const Eigen::Vector2f& at = made.left_pixel[i];
      const bool inside = at.x() > static_cast<float>(x0) && at.x() < static_cast<float>(x0 + 12) &&
                          at.y() > static_cast<float>(y0) && at.y() < static_cast<float>(y0 + 6);
      count += inside && made.view.noise_m[i] == 0.0F ? 1 : 0;
    }
    return count;
  };
  options.min_table_px = 200;
  EXPECT_EQ(table_samples_in_it(), 0);
  options.min_table_px = 0;
  EXPECT_GT(table_samples_in_it(), 3);
}

// A printed square in front of a wall whose texture is hardly stronger than the noise. Their
// disparities are 24 and 12 px.
struct SquareBeforeAWall {
  static constexpr int kWidth = 320, kHeight = 160, kFirst = 140, kLast = 220, kDisparity = 24,
                       kWallDisparity = 12;
  image::Grey8 left{kWidth, kHeight, {}}, right{kWidth, kHeight, {}};
  image::Image whole{kWidth, kHeight, {}};
  Mask all{kWidth, kHeight, std::vector<std::uint8_t>(kWidth* kHeight, 255)};

  static bool InSquare(int x, int y) { return x >= kFirst && x < kLast && y >= 40 && y < 120; }

  SquareBeforeAWall() {
    base::Rng rng(5);
    std::vector<double> print(kWidth * kHeight);
    for (double& level : print) level = rng.Uniform(0.0, 1.0);
    const auto print_at = [&](int x, int y) {
      return print[static_cast<std::size_t>(y * kWidth + std::min(x, kWidth - 1))];
    };
    const auto level = [&](int x, int y, double turn) {  // 0: the left picture, 1: the right one
      const int on_square = x + static_cast<int>(turn * kDisparity);
      const double clean =
          InSquare(on_square, y)
              ? 60.0 + 140.0 * print_at(on_square, y)
              : 148.0 + 4.0 * print_at(x + static_cast<int>(turn * kWallDisparity), y);
      return testing_support::Level(clean + 2.0 * rng.Normal());
    };
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        left.grey.push_back(level(x, y, 0));
        right.grey.push_back(level(x, y, 1));
        whole.rgb.insert(whole.rgb.end(), 3, left.grey.back());
      }
    }
  }

  /// The shares of the square and of the wall whose disparity is about that of the square.
  std::pair<double, double> SharesAsNear(const MatchOptions& options) const {
    const Disparity found = Match(left, right, all, whole, 8.0, 40.0, options);
    double square = 0.0, wall = 0.0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 60; x < kWidth; ++x) {  // nothing further left can be matched
        const float d = found.grey[static_cast<std::size_t>(y * kWidth + x)];
        const bool near = std::abs(d - kDisparity) < 4.0F;
        (InSquare(x, y) ? square : wall) += near ? 1.0 : 0.0;
      }
    }
    return {square / (80.0 * 80.0), wall / ((kWidth - 60.0) * kHeight - 80.0 * 80.0)};
  }
};

TEST(Match, LessOfAWallTakesOnTheDisparityOfWhatStandsBeforeIt) {
  const SquareBeforeAWall scene;
  MatchOptions options;
  const auto [square, wall] = scene.SharesAsNear(options);
  EXPECT_GT(square, 0.85);
  options.consensus_share = 0.0;
  options.min_edges = 0.0;
  const auto [square_before, wall_before] = scene.SharesAsNear(options);
  // If a whole neighborhood takes on the square's disparity, nothing reveals the error. If only a
  // part does, that part is removed.
  EXPECT_LT(wall, 0.85 * wall_before) << wall << " of the wall, " << wall_before << " before";
  EXPECT_GT(square, square_before - 0.05);
}

TEST(Match, NoiseAloneIsNoTexture) {
  const SquareBeforeAWall scene;
  base::Rng rng(9);
  image::Grey8 left{320, 160, {}}, right = left;
  image::Image whole{320, 160, {}};
  for (int i = 0; i < 320 * 160; ++i) {
    left.grey.push_back(testing_support::Level(150.0 + 2.0 * rng.Normal()));
    right.grey.push_back(testing_support::Level(150.0 + 2.0 * rng.Normal()));
    whole.rgb.insert(whole.rgb.end(), 3, left.grey.back());
  }
  MatchOptions options;
  options.uniqueness_percent = 0;
  const auto matched = [&] {
    const Disparity found = Match(left, right, scene.all, whole, 8.0, 40.0, options);
    return std::ranges::count_if(found.grey, [](float d) { return !std::isnan(d); });
  };
  EXPECT_EQ(matched(), 0);
  options.min_edges = 0.0;
  options.consensus_share = 0.0;
  options.min_patch_px = 0;
  EXPECT_GT(matched(), 1000);
}

}  // namespace
}  // namespace rangegrasp::stereo
