#include "stereo/hand_eye.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/rng.h"
#include "core/units.h"
#include "error_of.h"

namespace rangegrasp::stereo {
namespace {

using Eigen::Vector3d;
using testing_support::ErrorOf;

const Camera kCamera{800, 600, 900.0, 901.0, 402.0, 297.0, -0.10, 0.12, 0.0005, -0.0003, 0.0};
constexpr double kSigma_px = 0.05;  // of a corner, as cv::cornerSubPix finds it

core::Pose Turned(const Vector3d& turn, const Vector3d& shift) {
  return core::MakePose(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix(),
                        shift);
}

const core::Pose kTruth = Turned({0.02, -0.11, 3.10}, {-0.03, 0.04, 0.06});  // X_HC
const core::Pose kBoard = Turned({0.0, 0.0, 0.3}, {-0.10, -0.06, 0.002});    // X_WBoard

/// Looks at the board's middle from about 0.4 m, from all sides.
std::vector<HandEyeView> ViewsOf(int count, double sigma_px, core::Rng& rng, double spread = 0.5) {
  const ChessboardOptions board;
  const Vector3d middle = kBoard * Vector3d(0.1, 0.0625, 0.0);
  std::vector<HandEyeView> views;
  for (int i = 0; i < count; ++i) {
    const double around = rng.Uniform(-core::kPi, core::kPi) * spread * 2.0;
    const double lean = rng.Uniform(0.1, 0.1 + spread);
    const Vector3d away(std::sin(lean) * std::cos(around), std::sin(lean) * std::sin(around),
                        std::cos(lean));
    const Vector3d z = -away;
    const Vector3d x = z.cross(Vector3d::UnitY()).normalized();
    Eigen::Matrix3d R;
    R << x, z.cross(x), z;
    const core::Pose X_WC = core::MakePose(R, middle + rng.Uniform(0.36, 0.44) * away);
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

double AngleBetween(const core::Pose& a, const core::Pose& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle();
}

TEST(HandEye, FindsTheCameraExactlyWhereNothingIsNoisy) {
  core::Rng rng(1);
  const auto found = CalibrateHandEye(ViewsOf(8, 0.0, rng), kCamera, {});
  EXPECT_LT((found.X_HC.translation() - kTruth.translation()).norm(), 1e-7);
  EXPECT_LT(AngleBetween(found.X_HC, kTruth), 1e-7);
  EXPECT_LT((found.X_WBoard.translation() - kBoard.translation()).norm(), 1e-7);
  EXPECT_LT(found.rms_px, 1e-4);
}

class SeededHandEye : public testing::TestWithParam<std::uint64_t> {};

// 12 views of 54 corners: 0.05 px at 0.4 m and 900 px are 22 um a corner. A camera's shift trades
// against its turn (22 um over the board's 0.1 m are 0.2 mrad, over sqrt(12 * 54) = 25 less), and
// what its turn makes of 0.4 m: well below 0.2 mm and 0.5 mrad.
TEST_P(SeededHandEye, FindsTheCameraToAFewTenthsOfAMillimetre) {
  core::Rng rng(GetParam());
  const auto found = CalibrateHandEye(ViewsOf(12, kSigma_px, rng), kCamera, {});
  EXPECT_LT((found.X_HC.translation() - kTruth.translation()).norm(), 0.0002);
  EXPECT_LT(AngleBetween(found.X_HC, kTruth), 0.0005);
  // Two coordinates of each corner; what 12 parameters take of 1,296 is less than the bounds.
  EXPECT_NEAR(found.rms_px, kSigma_px * std::sqrt(2.0), 0.15 * kSigma_px);
}
INSTANTIATE_TEST_SUITE_P(Seeds, SeededHandEye, testing::Range<std::uint64_t>(1, 21));

TEST(HandEye, RefusesWhatDoesNotCalibrate) {
  core::Rng rng(2);
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(ViewsOf(4, 0.0, rng), kCamera, {}); }),
              testing::HasSubstr("4 views"));
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(ViewsOf(8, 0.0, rng, 0.005), kCamera, {}); }),
              testing::HasSubstr("the hand turned by"));
  auto moved = ViewsOf(8, 0.0, rng);
  for (auto& pixel : moved[3].corners_px) pixel.x() += 20.0;
  EXPECT_THAT(ErrorOf([&] { CalibrateHandEye(moved, kCamera, {}); }),
              testing::HasSubstr("was the board moved"));
  moved[3].corners_px.pop_back();
  EXPECT_THROW(CalibrateHandEye(moved, kCamera, {}), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::stereo
