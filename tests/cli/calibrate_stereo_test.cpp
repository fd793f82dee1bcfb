#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/command.h"
#include "geometry/cloud_file.h"
#include "image/png.h"
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
  void WriteView(const std::string& number, int width) const {
    const image::Image grey{width, 80, std::vector<std::uint8_t>(std::size_t(3 * width * 80), 90)};
    image::WritePng(folder_ / ("left_" + number + ".png"), grey);
    image::WritePng(folder_ / ("right_" + number + ".png"), grey);
    geometry::RangeImage board{.profiles = 1, .samples = 3, .points_C = {}, .origins_C = {}};
    board.points_C = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    board.origins_C = {{0.8, 0, 0.6}};
    geometry::WriteCloud(folder_ / ("board_" + number + ".pcd"), board);
  }

  const TempFolder folder_;
};

TEST_F(CalibrateStereo, AFolderWithoutViewsIsRefused) { ExpectRefused({}, "holds no left_01.png"); }

TEST_F(CalibrateStereo, PicturesWithoutTheChessboardAreNamed) {
  WriteView("01", 100);
  ExpectRefused({}, "view 1 (left): no chessboard with 9 x 6 inner corners");
  ExpectRefused({"--corners", "7x5"}, "no chessboard with 7 x 5 inner corners");
}

TEST_F(CalibrateStereo, CornersAreTwoNumbers) {
  WriteView("01", 100);
  for (const char* corners : {"9", "9x", "9x6x2", "2x6", "nine"}) {
    ExpectRefused({"--corners", corners}, "must be COLUMNSxROWS");
  }
}

}  // namespace
}  // namespace rangegrasp
