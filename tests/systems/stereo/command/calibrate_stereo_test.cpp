#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file.h"
#include "base/image/image.h"
#include "base/rng.h"
#include "cli/command.h"
#include "geometry/cloud_file.h"
#include "stereo/synthetic_board.h"
#include "temp_folder.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::RunProgram;
using testing_support::TempFolder;

class CalibrateStereo : public ::testing::Test {
 protected:
  void ExpectRefused(const std::vector<std::string>& more, const std::string& why) const {
    std::vector<std::string> arguments = {"calibrate-stereo", folder_.path().string(), "-o",
                                          (folder_ / "stereo.yaml").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto ran = RunProgram(arguments);
    EXPECT_EQ(ran.code, 2) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(why));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "stereo.yaml"));
  }

  /// Pictures without a chessboard, and a cloud of three points.
  void WriteView() const {
    const image::Image grey{100, 80, std::vector<std::uint8_t>(3 * 100 * 80, 90)};
    image::WritePng(folder_ / "left_01.png", grey);
    image::WritePng(folder_ / "right_01.png", grey);
    WriteScan(folder_ / "board_01.pcd", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  static void WriteScan(const std::filesystem::path& file, const geometry::Points& points_W) {
    geometry::WriteCloud(file, {.profiles = 1,
                                .samples = static_cast<int>(points_W.size()),
                                .points_C = points_W,
                                .origins_C = {{0.01, 0.02, 0.0}}});
  }

  const TempFolder folder_;
};

TEST_F(CalibrateStereo, AFolderWithoutViewsIsRefused) {
  ExpectRefused({}, "does not contain left_01.png");
}

TEST_F(CalibrateStereo, PicturesWithoutTheChessboardAreNamed) {
  WriteView();
  ExpectRefused({}, "view 1 (left): no chessboard with 9 x 6 inner corners");
  ExpectRefused({"--corners", "7x5"}, "no chessboard with 7 x 5 inner corners");
}

TEST_F(CalibrateStereo, FewerViewsThanAreNeededAreNotDrawn) {
  for (const char* views : {"1", "5", "201"}) {
    ExpectRefused({"--views", views}, "must be a whole number from 6 to 200");
  }
}

TEST_F(CalibrateStereo, CornersAreTwoNumbers) {
  WriteView();
  for (const char* corners : {"9", "9x", "9x6x2", "2x6", "nine"}) {
    ExpectRefused({"--corners", corners}, "must be COLUMNSxROWS");
  }
}

/// A folder of eight views of a board in front of a small camera. The left camera's frame is also
/// the arm's frame.
class RecordedBoards : public CalibrateStereo {
 protected:
  static constexpr int kViews = 8;
  static constexpr double kBaseline_m = 0.04;

  static void SetUpTestSuite() {
    recorded_ = new TempFolder;
    for (int number = 1; number <= kViews; ++number) WriteView(*recorded_, number, Tilt(number), 1);
  }
  static void TearDownTestSuite() { delete recorded_; }
  void SetUp() override {
    for (const auto& entry : std::filesystem::directory_iterator(recorded_->path())) {
      std::filesystem::copy_file(entry.path(), folder_ / entry.path().filename());
    }
  }

  static std::string Name(const char* what, int number) {
    return std::string(what) + "_0" + std::to_string(number);
  }
  /// Each view is tilted by a quarter of a radian in a different direction.
  static Eigen::Vector3d Tilt(int number) {
    const double way = 2.0 * 3.14159 * number / kViews;
    return {0.25 * std::cos(way) + 0.1, 0.25 * std::sin(way), 0.05};
  }
  /// The left camera in the right one's frame.
  static base::Pose LeftInRight() {
    return testing_support::TurnedBy({0, 0.05, 0}, {-kBaseline_m, 0, 0});
  }
  static void WriteView(const TempFolder& folder, int number, const Eigen::Vector3d& tilt,
                        int blur_px) {
    using testing_support::BoardPicture;
    using testing_support::TurnedBy;
    const stereo::ChessboardOptions board;
    const base::Pose X_LBoard =
        TurnedBy(tilt, {-0.10, -0.06 + 0.004 * (number % 3), 0.52 + 0.01 * number});
    const base::Pose X_RBoard = LeftInRight() * X_LBoard;
    image::WritePng(folder / (Name("left", number) + ".png"),
                    BoardPicture(X_LBoard, board, blur_px));
    image::WritePng(folder / (Name("right", number) + ".png"), BoardPicture(X_RBoard, board, 1));
    base::Rng rng(static_cast<std::uint64_t>(number));
    geometry::Points points;
    for (int i = 0; i < 500; ++i) {
      const double x = rng.Uniform(-0.03, 0.23);
      const double y = rng.Uniform(-0.03, 0.15);
      points.push_back(X_LBoard * Eigen::Vector3d(x, y, 0.0003 * rng.Normal()));
    }
    WriteScan(folder / (Name("board", number) + ".pcd"), points);
  }
  std::filesystem::path Picture(const char* side, int number) const {
    return folder_ / (Name(side, number) + ".png");
  }

  static inline TempFolder* recorded_ = nullptr;
};

TEST_F(RecordedBoards, Calibrate) {
  const auto ran = RunProgram(
      {"calibrate-stereo", folder_.path().string(), "-o", (folder_ / "stereo.yaml").string()});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("8 views"));
  const auto found = stereo::ReadStereoCalibration(folder_ / "stereo.yaml");
  // 500 points per view with a noise of 0.3 mm place the cameras to 0.2 mm.
  EXPECT_LT(found.X_WL.translation().norm(), 0.001);
  EXPECT_LT((found.X_WR.translation() - LeftInRight().inverse().translation()).norm(), 0.001);
  EXPECT_NEAR(stereo::RightInLeft(found).translation().norm(), kBaseline_m, 0.0002);
}

TEST_F(RecordedBoards, WithAnotherNumberOfCornersAreRefused) {
  ExpectRefused({"--corners", "8x6"}, "view 1 (left): no chessboard with 8 x 6 inner corners");
}

// Pictures alone cannot reveal the wrong size. The laser can, because it measures lengths.
TEST_F(RecordedBoards, WithSquaresOfAnotherSizeAreRefused) {
  ExpectRefused({"--square-mm", "26"}, "are its squares 26 mm");
}

TEST_F(RecordedBoards, SeenFromOneSideAloneAreRefused) {
  const image::Image grey{480, 360, std::vector<std::uint8_t>(3 * 480 * 360, 90)};
  image::WritePng(Picture("right", 2), grey);
  ExpectRefused({}, "view 2 (right): no chessboard");
}

TEST_F(RecordedBoards, ThatAreBlurredAreRefused) {
  WriteView(folder_, 1, Tilt(1), 7);
  ExpectRefused({}, "view 1 (left): the chessboard is blurred");
}

TEST_F(RecordedBoards, ThatTheLaserMissesAreRefused) {
  base::Rng rng(1);
  geometry::Points anywhere;
  for (int i = 0; i < 500; ++i) {
    const double x = rng.Uniform(-0.2, 0.2);
    const double y = rng.Uniform(-0.2, 0.2);
    const double z = rng.Uniform(0.4, 0.8);
    anywhere.emplace_back(x, y, z);
  }
  WriteScan(folder_ / "board_01.pcd", anywhere);
  ExpectRefused({}, "view 1: the laser measured no plane of the board in 500 points");
}

// The laser saw the wall behind the board instead of the board. With a wall that is far away, the
// fit diverges, and its distance says nothing.
TEST_F(RecordedBoards, WhoseScanIsOfAnotherPlaneAreRefused) {
  for (const auto& [z_m, said] : {std::pair{0.9, "off the laser's planes"},
                                  std::pair{90.0, "are more than 1 m off the laser's planes"}}) {
    base::Rng rng(1);
    geometry::Points wall;
    for (int i = 0; i < 500; ++i) {
      const double x = rng.Uniform(-0.2, 0.2);
      const double y = rng.Uniform(-0.2, 0.2);
      wall.emplace_back(x, y, z_m + 0.0003 * rng.Normal());
    }
    WriteScan(folder_ / "board_05.pcd", wall);
    ExpectRefused({}, said);
  }
}

TEST_F(RecordedBoards, ThatAreAllParallelAreRefused) {
  for (int number = 1; number <= kViews; ++number) WriteView(folder_, number, Tilt(1), 1);
  ExpectRefused({}, "tilted too little between its views");
}

TEST_F(RecordedBoards, OfTooFewViewsAreRefused) {
  std::filesystem::remove(Picture("left", 4));
  ExpectRefused({}, "3 views of the chessboard are too few to calibrate");
}

TEST_F(RecordedBoards, WithPicturesOfDifferentSizeAreRefused) {
  const image::Image small{320, 240, std::vector<std::uint8_t>(3 * 320 * 240, 90)};
  image::WritePng(Picture("right", 1), small);
  ExpectRefused({}, "both must have the same size");
  image::WritePng(Picture("left", 1), small);
  ExpectRefused({}, "view 1 (left): no chessboard");
}

TEST_F(RecordedBoards, WithOneGreyAndOneColourPictureAreRefused) {
  image::WritePng(Picture("left", 1),
                  image::Grey8{480, 360, std::vector<std::uint8_t>(480 * 360, 90)});
  ExpectRefused({}, "both must have the same format");
}

TEST_F(RecordedBoards, WithABrokenPictureAreRefused) {
  const std::string bytes = base::ReadFile(Picture("right", 1));
  base::WriteFile(Picture("right", 1), bytes.substr(0, bytes.size() / 2));
  ExpectRefused({}, "right_01.png: ");
}

TEST_F(RecordedBoards, WithAMissingFileAreRefused) {
  std::filesystem::remove(Picture("right", 1));
  ExpectRefused({}, "right_01.png");
  std::filesystem::copy_file(Picture("left", 1), Picture("right", 1));
  std::filesystem::remove(folder_ / "board_01.pcd");
  ExpectRefused({}, "board_01.pcd");
}

}  // namespace
}  // namespace rangegrasp
