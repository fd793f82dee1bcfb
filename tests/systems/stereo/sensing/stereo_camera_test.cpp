#include "stereo/sensing/stereo_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "error_of.h"
#include "stereo/calibrate.h"
#include "temp_folder.h"

namespace rangegrasp::sensing {
namespace {

stereo::Camera Lens() {
  return {200, 150, 250.0, 250.0, 101.3, 72.8, -0.11, 0.14, 6e-4, -4e-4, 0.0};
}

/// A picture whose red encodes the column and whose green encodes the row.
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

// A pixel shows what lies on its ray (inverse of equations 5.10 to 5.12).
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
      // Places are stored to 1/256 px, values to 1/64 of a level.
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
  EXPECT_NEAR(squares / sum, 0.6 * 0.6, 0.02);  // rounded to levels of 255
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
  // Five standard errors. The 4,096 quantiles lack 0.04 % of the variance.
  EXPECT_NEAR(std::sqrt(squares / n), 192.0, 5 * 192 / std::sqrt(2 * n) + 0.1);
}

using ::testing::HasSubstr;
using testing_support::ErrorOf;

const std::string kRoot = RANGEGRASP_SOURCE_DIR;

/// A camera with a quarter of the default's pixels along each edge and the same view.
StereoCameraOptions SmallCamera() {
  StereoCameraOptions options;
  options.width = 400;
  options.height = 300;
  options.focal_px = 500.0;
  options.center_right_px = 1.8;
  options.center_down_px = -1.4;
  options.shadow_px = 1024;
  return options;
}

/// A red box in the middle of the blue table.
class StereoCameraOnTheTable : public ::testing::Test {
 protected:
  StereoCameraOnTheTable()
      : world_(kRoot + "/scenes/tabletop.xml",
               {{"dextrose", kRoot + "/models/objects/dextrose/dextrose.xml"}}, {}),
        X_WS_(world_.SitePose("scanner")) {
    world_.PlaceObject(
        0, base::MakePose(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                          {-0.03, 0.02, 0.0675}));
  }

  StereoShot Shoot(const StereoCameraOptions& options, std::uint64_t seed) const {
    base::Rng rng(seed);
    return StereoCamera(options).Photograph(world_, X_WS_, rng);
  }

  /// The share of pixels that are bluest on the table and not bluest on the box, if the truth is
  /// looked up with the offset `beside` in pixels.
  double Agreement(const StereoShot& shot, const image::Image& photo, const base::Pose& X_WC,
                   const Eigen::Vector2d& beside) const {
    std::vector<Eigen::Vector2d> pixels;
    for (int y = 20; y < 280; ++y) {
      for (int x = 20; x < 380; ++x) pixels.emplace_back(x, y);
    }
    std::vector<Eigen::Vector2d> looked_up;
    for (const Eigen::Vector2d& pixel : pixels) looked_up.push_back(pixel + beside);
    const auto truth = TruthOfPixels(world_.VisualMeshes(), shot.truth.lens, X_WC, looked_up);
    int right = 0, all = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Eigen::Vector3d ray = stereo::RayOf(shot.truth.lens, looked_up[i]);
      const Eigen::Vector3d p_W = X_WC * Eigen::Vector3d(truth[i].depth_m * ray);
      const bool box = truth[i].label == 1;
      // Only the laminate counts, not what is painted on it, nor the room.
      if (!box && (std::abs(p_W.z()) > 1e-4 || p_W.head<2>().norm() > 0.2)) continue;
      const std::uint8_t* rgb =
          photo.At(static_cast<int>(pixels[i].x()), static_cast<int>(pixels[i].y()));
      const bool blue = rgb[2] > rgb[0] + 20 && rgb[2] > rgb[1] + 20;
      right += blue != box;
      ++all;
    }
    return double(right) / all;
  }

  sim::World world_;
  base::Pose X_WS_;
};

TEST(StereoCamera, ATurnMovesItToTheSide) {
  StereoCameraOptions options;
  options.mount_right_m = options.mount_down_m = 0.0;
  options.mount_roll_rad = options.mount_pitch_rad = options.mount_yaw_rad = 0.0;
  const base::Pose X_SL = CameraInHead(options, options.left_pan_rad);
  const base::Pose X_SR = CameraInHead(options, options.right_pan_rad);
  EXPECT_TRUE(X_SR.linear().isIdentity(1e-12));
  EXPECT_TRUE(X_SR.translation().isApprox(Eigen::Vector3d(0, 0, 0.3), 1e-12));
  const Eigen::Vector3d baseline = X_SR.translation() - X_SL.translation();
  EXPECT_NEAR(baseline.norm(), 0.6 * std::sin(base::Deg(2.0)), 1e-12);  // a chord of 4 degrees
  EXPECT_GT(baseline.x(), 0.02);  // the right picture is taken from the right
}

// Pictures, labels and the lens agree to the pixel: with an offset they agree less. The box's print
// is nowhere bluest (its navy line is 2 mm wide).
TEST_F(StereoCameraOnTheTable, PicturesShowWhatTheTruthSays) {
  const StereoShot shot = Shoot(SmallCamera(), 1);
  const auto check = [&](const image::Image& photo, const base::Pose& X_WC) {
    const double here = Agreement(shot, photo, X_WC, {0, 0});
    EXPECT_GT(here, 0.98);
    for (const Eigen::Vector2d& beside : {Eigen::Vector2d(2, 0), Eigen::Vector2d(-2, 0),
                                          Eigen::Vector2d(0, 2), Eigen::Vector2d(0, -2)}) {
      EXPECT_LT(Agreement(shot, photo, X_WC, beside), here);
    }
  };
  check(shot.photos.left, shot.truth.X_WL);
  check(shot.photos.right, shot.truth.X_WR);
}

// The corners of a chessboard appear where the lens images them (5.10 to 5.12), each to a tenth of
// a pixel and without a common offset.
TEST(StereoCamera, ImagesAChessboardWhereItIs) {
  sim::World world(kRoot + "/scenes/tabletop.xml",
                   {{"chessboard", kRoot + "/models/calibration/chessboard/chessboard.xml"}}, {});
  StereoCameraOptions options;
  options.fine_print = false;
  options.pan_sigma_rad = 0.0;
  const base::Pose X_WS = world.SitePose("scanner");
  const base::Pose X_WC = X_WS * CameraInHead(options, options.left_pan_rad);
  const Eigen::Matrix3d facing = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(base::kPi, Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
  const base::Pose X_CBoard = base::MakePose(facing, {-0.01, 0.0, 0.62});
  world.PlaceObject(0, X_WC * X_CBoard);
  base::Rng rng(1);
  const StereoShot shot = StereoCamera(options).Photograph(world, X_WS, rng);
  stereo::BoardView view{"view", shot.photos.left, shot.photos.right, {}, X_WS.translation()};
  for (int i = 0; i < 200; ++i) {  // what a laser without noise would measure
    const Eigen::Vector3d p(0.01 * (i % 20) - 0.1, 0.01 * (i / 20) - 0.05, 0.0025);
    view.laser_W.push_back(X_WC * X_CBoard * p);
  }
  const stereo::BoardSighting found = stereo::FindBoard(view, {});
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0.0;
  for (const Eigen::Vector2d& seen : found.left_px) {
    Eigen::Vector2d nearest(1e9, 1e9);
    for (int i = 0; i < 54; ++i) {
      const Eigen::Vector3d corner((i % 9 - 4) * 0.025, (i / 9 - 2.5) * 0.025, 0.0025);
      const Eigen::Vector2d off = seen - stereo::Project(shot.truth.lens, X_CBoard * corner);
      if (off.norm() < nearest.norm()) nearest = off;
    }
    sum += nearest;
    squares += nearest.squaredNorm();
  }
  EXPECT_LT((sum / 54.0).norm(), 0.05);
  EXPECT_LT(std::sqrt(squares / 54.0), 0.14);  // a tenth in each direction
}

TEST_F(StereoCameraOnTheTable, TheSameSeedTakesTheSamePictures) {
  const StereoShot a = Shoot(SmallCamera(), 1);
  const StereoShot b = Shoot(SmallCamera(), 1);
  EXPECT_EQ(a.photos.left.rgb, b.photos.left.rgb);
  EXPECT_EQ(a.photos.right.rgb, b.photos.right.rgb);
  const StereoShot c = Shoot(SmallCamera(), 2);
  EXPECT_NE(a.photos.left.rgb, c.photos.left.rgb);
}

// Two pictures that differ only in their noise differ by sqrt(2) times its standard deviation.
TEST_F(StereoCameraOnTheTable, NoiseHasItsDeviation) {
  StereoCameraOptions options = SmallCamera();
  options.exposure_sigma = 0.0;
  options.pan_sigma_rad = 0.0;
  const image::Image a = Shoot(options, 1).photos.left;
  const image::Image b = Shoot(options, 2).photos.left;
  double squares = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    // Only values away from both ends of the range.
    if (a.rgb[i] < 20 || b.rgb[i] < 20 || a.rgb[i] > 235 || b.rgb[i] > 235) continue;
    const double difference = double(a.rgb[i]) - b.rgb[i];
    squares += difference * difference;
    ++n;
  }
  ASSERT_GT(n, 100000);
  // Rounding to levels adds a variance of 1/12. The tolerance is five standard errors.
  const double wanted = std::sqrt(2.0 * (9.0 + 1.0 / 12.0));
  EXPECT_NEAR(std::sqrt(squares / n), wanted, 5.0 * wanted / std::sqrt(2.0 * n) + 0.01);
}

TEST_F(StereoCameraOnTheTable, FinePrintIsSeenOnTheBoxAlone) {
  StereoCameraOptions options = SmallCamera();
  options.noise_levels = 0.0;
  const StereoShot printed = Shoot(options, 1);
  options.fine_print = false;
  const StereoShot plain = Shoot(options, 1);
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) pixels.emplace_back(x, y);
  }
  const auto truth =
      TruthOfPixels(world_.VisualMeshes(), plain.truth.lens, plain.truth.X_WL, pixels);
  int box = 0, changed_on_box = 0, changed_elsewhere = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int difference = std::abs(printed.photos.left.rgb[3 * i] - plain.photos.left.rgb[3 * i]);
    box += truth[i].label == 1;
    (truth[i].label == 1 ? changed_on_box : changed_elsewhere) += difference > 8;
  }
  EXPECT_GT(changed_on_box, box / 20);
  EXPECT_LT(changed_elsewhere, box / 20);  // reflections and edges
}

TEST(StereoCameraOptions, AreReadInTheUnitsOfPeople) {
  const testing_support::TempFolder folder;
  folder.Write("camera.yaml", "type: stereo_camera\nahead_mm: 150\nright_pan_deg: 1\n");
  const StereoCameraOptions options = ReadStereoCamera(folder / "camera.yaml");
  EXPECT_DOUBLE_EQ(options.ahead_m, 0.15);
  EXPECT_DOUBLE_EQ(options.right_pan_rad, base::Deg(1.0));
  EXPECT_EQ(options.width, StereoCameraOptions{}.width);
}

TEST(StereoCameraOptions, NameWhatIsWrong) {
  const testing_support::TempFolder folder;
  const auto error = [&folder](const std::string& text) {
    folder.Write("camera.yaml", text);
    return ErrorOf([&] { ReadStereoCamera(folder / "camera.yaml"); });
  };
  EXPECT_THAT(error("type: line_scanner"), HasSubstr("must be stereo_camera"));
  EXPECT_THAT(error("left_pan_deg: 3"), HasSubstr("left_pan_deg must be less than right_pan_deg"));
  EXPECT_THAT(error("nose_levels: 3"), HasSubstr("noise_levels"));
}

}  // namespace
}  // namespace rangegrasp::sensing
