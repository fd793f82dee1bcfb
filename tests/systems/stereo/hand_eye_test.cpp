#include "sensing/hand_eye.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "error_of.h"
#include "stereo/calibrate_hand_eye.h"
#include "stereo/synthetic_board.h"
#include "temp_folder.h"

namespace rangegrasp::stereo {
namespace {

using Eigen::Vector3d;
using testing_support::ErrorOf;
using testing_support::TurnedBy;

const Camera kCamera{800, 600, 900.0, 901.0, 402.0, 297.0, -0.10, 0.12, 0.0005, -0.0003, 0.0};
constexpr double kSigma_px = 0.05;  // of a corner that cv::cornerSubPix finds

const base::Pose kTruth = TurnedBy({0.02, -0.11, 3.10}, {-0.03, 0.04, 0.06});  // X_HC
const base::Pose kBoard = TurnedBy({0.0, 0.0, 0.3}, {-0.10, -0.06, 0.002});    // X_WBoard

/// Views of the board's middle from about 0.4 m, from all sides.
std::vector<HandEyeView> ViewsOf(int count, double sigma_px, base::Rng& rng, double spread = 0.5) {
  const ChessboardOptions board;
  const Vector3d middle = kBoard * Vector3d(0.1, 0.0625, 0.0);
  std::vector<HandEyeView> views;
  for (int i = 0; i < count; ++i) {
    const double around = rng.Uniform(-base::kPi, base::kPi) * spread * 2.0;
    const double lean = rng.Uniform(0.1, 0.1 + spread);
    const Vector3d away(std::sin(lean) * std::cos(around), std::sin(lean) * std::sin(around),
                        std::cos(lean));
    const Vector3d z = -away;
    const Vector3d x = z.cross(Vector3d::UnitY()).normalized();
    Eigen::Matrix3d R;
    R << x, z.cross(x), z;
    const base::Pose X_WC = base::MakePose(R, middle + rng.Uniform(0.36, 0.44) * away);
    HandEyeView view{X_WC * kTruth.inverse(), {}};
    for (int row = 0; row < board.rows; ++row) {
      for (int column = 0; column < board.columns; ++column) {
        const Vector3d p(column * board.square_m, row * board.square_m, 0.0);
        const Eigen::Vector2d pixel = Project(kCamera, X_WC.inverse() * (kBoard * p));
        const double u = rng.Normal();
        const double v = rng.Normal();
        view.corners_px.push_back(pixel + sigma_px * Eigen::Vector2d(u, v));
      }
    }
    views.push_back(view);
  }
  return views;
}

double AngleBetween(const base::Pose& a, const base::Pose& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle();
}

TEST(HandEye, FindsTheCameraExactlyWhereNothingIsNoisy) {
  base::Rng rng(1);
  const auto found = CalibrateHandEye(ViewsOf(8, 0.0, rng), kCamera, {});
  EXPECT_LT((found.X_HC.translation() - kTruth.translation()).norm(), 1e-7);
  EXPECT_LT(AngleBetween(found.X_HC, kTruth), 1e-7);
  EXPECT_LT((found.X_WBoard.translation() - kBoard.translation()).norm(), 1e-7);
  EXPECT_LT(found.rms_px, 1e-4);
}

class SeededHandEye : public testing::TestWithParam<std::uint64_t> {};

// 12 views of 54 corners. 0.05 px at 0.4 m with a focal length of 900 px are 22 um per corner. A
// camera's shift trades off against its rotation (22 um over the board's 0.1 m are 0.2 mrad,
// reduced by sqrt(12 * 54) = 25) and the effect of its rotation at 0.4 m. The errors are therefore
// well below 0.2 mm and 0.5 mrad.
TEST_P(SeededHandEye, FindsTheCameraToAFewTenthsOfAMillimetre) {
  base::Rng rng(GetParam());
  const auto found = CalibrateHandEye(ViewsOf(12, kSigma_px, rng), kCamera, {});
  EXPECT_LT((found.X_HC.translation() - kTruth.translation()).norm(), 0.0002);
  EXPECT_LT(AngleBetween(found.X_HC, kTruth), 0.0005);
  // Each corner has two coordinates. The effect of 12 parameters on 1,296 coordinates is less than
  // the tolerance.
  EXPECT_NEAR(found.rms_px, kSigma_px * std::sqrt(2.0), 0.15 * kSigma_px);
}
// The stated error is right on average over all seeds. It includes the arm's own error.
TEST(HandEye, KnowsHowWellItKnows) {
  double squares_m2 = 0.0, said_m2 = 0.0, squares_rad2 = 0.0, said_rad2 = 0.0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    base::Rng rng(seed);
    auto views = ViewsOf(12, kSigma_px, rng);
    for (HandEyeView& view : views) {
      view.X_WH = view.X_WH * base::DrawRigidError(0.0002, 0.0005, rng);
    }
    ChessboardOptions board;
    board.max_reprojection_px = 2.0;
    const auto found = CalibrateHandEye(views, kCamera, board);
    squares_m2 += (found.X_HC.translation() - kTruth.translation()).squaredNorm() / kSeeds;
    said_m2 += found.shift_error_m * found.shift_error_m / kSeeds;
    squares_rad2 += std::pow(AngleBetween(found.X_HC, kTruth), 2) / kSeeds;
    said_rad2 += found.turn_error_rad * found.turn_error_rad / kSeeds;
  }
  // The root mean square of twenty draws of six numbers is good to a tenth. The jackknife states
  // somewhat larger errors.
  EXPECT_NEAR(std::sqrt(said_m2 / squares_m2), 1.1, 0.4);
  EXPECT_NEAR(std::sqrt(said_rad2 / squares_rad2), 1.1, 0.4);
}

// A camera that is rotated about its optical axis sees the board's other end first.
TEST(FindBoardCorners, BeginAtTheSameEndHoweverTheCameraIsTurned) {
  const ChessboardOptions board;
  const Camera camera = testing_support::BoardCamera();
  for (int eighth = 0; eighth < 8; ++eighth) {
    const double roll = eighth * base::kPi / 4.0 + 0.1;
    const base::Pose X_CBoard = TurnedBy({0.0, 0.0, roll}, {0.0, 0.0, 0.62}) *
                                TurnedBy({0.1, 0.15, 0.0}, {0.0, 0.0, 0.0}) *
                                TurnedBy({0, 0, 0}, {-0.1, -0.0625, 0.0});
    const auto corners =
        FindBoardCorners(testing_support::BoardPicture(X_CBoard, board, 1), "a view", board);
    ASSERT_EQ(corners.size(), 54u);
    for (const int i : {0, 8, 45, 53}) {
      const Vector3d p(i % 9 * board.square_m, i / 9 * board.square_m, 0.0);
      EXPECT_LT((corners[static_cast<std::size_t>(i)] - Project(camera, X_CBoard * p)).norm(), 0.5)
          << eighth << ", corner " << i;
    }
  }
}

TEST(FindBoardCorners, OfABoardWithTwoLikeEndsAreRefused) {
  const image::Image grey{64, 64, std::vector<std::uint8_t>(3 * 64 * 64, 90)};
  ChessboardOptions board;
  board.columns = 8;
  EXPECT_THAT(ErrorOf([&] { FindBoardCorners(grey, "a view", board); }),
              testing::HasSubstr("8 x 6 inner corners looks the same from both ends"));
}

TEST(HandEyeFiles, KeepEveryDigit) {
  const testing_support::TempFolder folder;
  sensing::WriteHandEye({kTruth, 0.00013, 0.0004}, folder / "hand_eye.yaml");
  const sensing::HandEye read = sensing::ReadHandEye(folder / "hand_eye.yaml");
  EXPECT_TRUE(read.X_HS.isApprox(kTruth, 1e-14));
  EXPECT_DOUBLE_EQ(read.shift_error_m, 0.00013);
  EXPECT_DOUBLE_EQ(read.turn_error_rad, 0.0004);
  WriteHandEyeRecord({kCamera, kBoard, {kTruth, kBoard}}, folder / "views.yaml");
  const HandEyeRecord record = ReadHandEyeRecord(folder / "views.yaml");
  EXPECT_EQ(record.camera, kCamera);
  ASSERT_EQ(record.X_WH.size(), 2u);
  EXPECT_TRUE(record.X_WH[0].isApprox(kTruth, 1e-14));
  EXPECT_TRUE(record.X_SC.isApprox(kBoard, 1e-14));
}

TEST(HandEyeFiles, NameTheKeyThatIsWrong) {
  const testing_support::TempFolder folder;
  base::WriteFile(folder / "a.yaml", "error_mm: 1\n");
  EXPECT_THAT(ErrorOf([&] { sensing::ReadHandEye(folder / "a.yaml"); }),
              testing::HasSubstr("head"));
  base::WriteFile(folder / "a.yaml",
                  "head: {x_mm: 1, y_mm: 1, z_mm: 1, qw: 1, qx: 0.5, qy: 0, qz: 0}\n");
  EXPECT_THAT(ErrorOf([&] { sensing::ReadHandEye(folder / "a.yaml"); }),
              testing::HasSubstr("the quaternion's length is 1.11803"));
}

INSTANTIATE_TEST_SUITE_P(Seeds, SeededHandEye, testing::Range<std::uint64_t>(1, 21));

TEST(HandEye, RefusesWhatDoesNotCalibrate) {
  base::Rng rng(2);
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(ViewsOf(4, 0.0, rng), kCamera, {}); }),
              testing::HasSubstr("4 views"));
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(ViewsOf(8, 0.0, rng, 0.005), kCamera, {}); }),
              testing::HasSubstr("the hand turned by"));
  auto moved = ViewsOf(8, 0.0, rng);
  for (auto& pixel : moved[3].corners_px) pixel.x() += 20.0;
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(moved, kCamera, {}); }),
              testing::HasSubstr("was the board moved"));
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(moved, kCamera, {}); }),
              testing::HasSubstr("most in view_04 ("));
  moved[3].corners_px.pop_back();
  EXPECT_THROW(CalibrateHandEye(moved, kCamera, {}), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::stereo
