// The output of `stereo` for two recorded pictures, and its errors for pictures and calibrations
// that do not match.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"
#include "base/image/image.h"
#include "cli/command.h"
#include "geometry/cloud_file.h"
#include "stereo/synthetic_pair.h"

namespace rangegrasp::testing_support {
namespace {

using testing::HasSubstr;

class StereoTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const stereo::StereoCalibration calibration = SyntheticCalibration();
    left_ = new image::Image(Picture(TwoBoxes(), calibration.camera, calibration.X_WL, 2.0, 1));
    right_ = new image::Image(Picture(TwoBoxes(), calibration.camera, calibration.X_WR, 2.0, 2));
  }
  static void TearDownTestSuite() {
    delete left_;
    delete right_;
  }

  void SetUp() override {
    image::WritePng(folder_ / "left.png", *left_);
    image::WritePng(folder_ / "right.png", *right_);
    stereo::WriteStereoCalibration(SyntheticCalibration(), folder_ / "stereo.yaml");
  }

  Ran Stereo(const std::vector<std::string>& more = {}) const {
    const auto path = [this](const char* name) { return (folder_ / name).string(); };
    std::vector<std::string> arguments = {"stereo",
                                          path("left.png"),
                                          path("right.png"),
                                          "--calibration",
                                          path("stereo.yaml"),
                                          "--near-mm",
                                          "350",
                                          "--far-mm",
                                          "900",
                                          "-o",
                                          path("cloud.pcd")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  void ExpectRefused(const std::string& reason) const {
    const Ran ran = Stereo();
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.err, HasSubstr(reason));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "cloud.pcd"));
  }

  TempFolder folder_;
  static inline image::Image* left_ = nullptr;
  static inline image::Image* right_ = nullptr;
};

image::Grey8 RedOf(const image::Image& picture) {
  image::Grey8 grey{picture.width, picture.height, {}};
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) grey.grey.push_back(picture.rgb[i]);
  return grey;
}

TEST_F(StereoTest, MakesACloudOfTheBoxesAndTheTable) {
  const Ran ran =
      Stereo({"--table-mm", "0", "--step-px", "2", "--pictures", (folder_ / "made").string()});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto cloud = geometry::ReadCloud(folder_ / "cloud.pcd");
  int on_box = 0, on_table = 0;
  for (const auto& p : cloud.points) {
    if (!p.allFinite()) continue;
    on_table += std::abs(p.z()) < 1e-4 ? 1 : 0;
    // The top of the printed box is 90 mm high. Half a millimetre is a sixth of a pixel.
    on_box += std::abs(p.z() - 0.09) < 0.004 && p.y() < -0.02 ? 1 : 0;
  }
  EXPECT_GT(on_table, 1000);
  EXPECT_GT(on_box, 300);
  EXPECT_EQ(image::ReadPng<image::Image>(folder_ / "made" / "disparity.png").width, 400);
}

TEST_F(StereoTest, SaysHowManyBluePixelsAreLeftOut) {
  EXPECT_THAT(Stereo().err, testing::ContainsRegex("[0-9]{4,} blue pixels .the table. left out"));
  EXPECT_THAT(Stereo({"--table-mm", "0"}).err, testing::Not(HasSubstr("left out")));
  EXPECT_THAT(Stereo({"--keep-blue"}).err, testing::Not(HasSubstr("left out")));
}

TEST_F(StereoTest, TakesTwoGreyPictures) {
  image::WritePng(folder_ / "left.png", RedOf(*left_));
  image::WritePng(folder_ / "right.png", RedOf(*right_));
  EXPECT_EQ(Stereo().code, 0);
}

TEST_F(StereoTest, RefusesPicturesOfDifferentSize) {
  image::Image small{320, 240, std::vector<std::uint8_t>(3 * 320 * 240, 90)};
  image::WritePng(folder_ / "right.png", small);
  ExpectRefused("320 x 240");
}

TEST_F(StereoTest, RefusesOneGreyAndOneColourPicture) {
  image::WritePng(folder_ / "right.png", RedOf(*right_));
  ExpectRefused("both must have the same format");
}

TEST_F(StereoTest, RefusesABrokenPicture) {
  const std::string bytes = base::ReadFile(folder_ / "right.png");
  base::WriteFile(folder_ / "right.png", bytes.substr(0, bytes.size() / 2));
  ExpectRefused("right.png: ");
}

TEST_F(StereoTest, RefusesTheCalibrationOfACameraOfAnotherSize) {
  auto calibration = SyntheticCalibration();
  calibration.camera.width = 640;
  stereo::WriteStereoCalibration(calibration, folder_ / "stereo.yaml");
  ExpectRefused("the calibration of another camera");
}

// A camera that has been rotated by 0.5 to 6 degrees since the calibration no longer matches it. A
// rotation about the vertical axis is not detected because it moves nothing out of its row.
TEST_F(StereoTest, RefusesTheCalibrationOfAnotherCameraOfThatSize) {
  for (const auto& [axis, degrees] :
       std::vector<std::pair<Eigen::Vector3d, double>>{{Eigen::Vector3d::UnitX(), 0.5},
                                                       {Eigen::Vector3d::UnitX(), 1.0},
                                                       {Eigen::Vector3d::UnitX(), -2.0},
                                                       {Eigen::Vector3d::UnitX(), 6.0},
                                                       {Eigen::Vector3d::UnitZ(), 6.0}}) {
    auto calibration = SyntheticCalibration();
    calibration.X_WL.rotate(Eigen::AngleAxisd(base::Deg(degrees), axis));
    stereo::WriteStereoCalibration(calibration, folder_ / "stereo.yaml");
    SCOPED_TRACE(degrees);
    ExpectRefused("calibrate again");
  }
}

// Only the lower rows of the left picture, with a fifth of the print, are also in the right one.
// The rows above show a different print.
TEST_F(StereoTest, TakesPicturesThatShowLittleInCommon) {
  image::Image left = *left_;
  const stereo::StereoCalibration calibration = SyntheticCalibration();
  SyntheticScene other = TwoBoxes();
  for (TexturedBox& box : other.boxes) {
    box.min_W.x() += 0.5;  // another part of the pattern
    box.max_W.x() += 0.5;
  }
  base::Pose X_WElsewhere = calibration.X_WL;
  X_WElsewhere.pretranslate(Eigen::Vector3d(0.5, 0.0, 0.0));
  const image::Image elsewhere = Picture(other, calibration.camera, X_WElsewhere, 2.0, 3);
  const std::size_t upper = 3 * 400 * 185;
  std::copy_n(elsewhere.rgb.begin(), upper, left.rgb.begin());
  image::WritePng(folder_ / "left.png", left);
  const Ran ran = Stereo();
  EXPECT_EQ(ran.code, 0) << ran.err;
}

TEST_F(StereoTest, RefusesExchangedPictures) {
  auto calibration = SyntheticCalibration();
  std::swap(calibration.X_WL, calibration.X_WR);
  stereo::WriteStereoCalibration(calibration, folder_ / "stereo.yaml");
  ExpectRefused("exchange");
}

}  // namespace
}  // namespace rangegrasp::testing_support
