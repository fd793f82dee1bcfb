#include "stereo/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/rng.h"
#include "base/units.h"
#include "error_of.h"
#include "synthetic_board.h"

namespace rangegrasp::stereo {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing_support::BoardPicture;
using testing_support::ErrorOf;
using testing_support::kParts;
using testing_support::kSpot_px;
using testing_support::TurnedBy;

Camera LensUsed() { return {640, 480, 800.0, 800.0, 322.3, 236.1, -0.11, 0.14, 6e-4, -4e-4, 0.0}; }

/// A rotation by 4 degrees about an axis 0.3 m behind the camera.
base::Pose TurnUsed() {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(base::Deg(4.0), Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Eigen::Vector3d ahead(0.0, 0.0, 0.3);
  return base::MakePose(turn, turn * ahead - ahead);
}

base::Pose PlaceUsed() { return TurnedBy({0.3, 2.1, 0.2}, {0.56, -0.02, 0.45}); }

/// A random pose of the board in front of the left camera, in full view of both pictures.
base::Pose BoardPlace(base::Rng& rng) {
  const double tilt = rng.Uniform(-0.6, 0.6);
  const double lean = rng.Uniform(-0.6, 0.6);
  const double right = rng.Uniform(-0.05, 0.05);
  const double down = rng.Uniform(-0.04, 0.04);
  const double depth = rng.Uniform(0.55, 0.75);
  return base::MakePose((Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) *
                         Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY()))
                            .toRotationMatrix(),
                        {right - 0.08, down - 0.06, depth});
}

BoardSighting Sighting(const base::Pose& X_LBoard, const ChessboardOptions& options,
                       double noise_px, base::Rng& rng) {
  BoardSighting sighting;
  sighting.name = "view";
  const base::Pose X_RBoard = TurnUsed().inverse() * X_LBoard;
  const auto see = [&](const base::Pose& X_CBoard, const Eigen::Vector3d& corner) {
    const double x = noise_px * rng.Normal();
    const double y = noise_px * rng.Normal();
    return Eigen::Vector2d(Project(LensUsed(), X_CBoard * corner) + Eigen::Vector2d(x, y));
  };
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      const Eigen::Vector3d corner(column * options.square_m, row * options.square_m, 0.0);
      sighting.left_px.push_back(see(X_LBoard, corner));
      sighting.right_px.push_back(see(X_RBoard, corner));
    }
  }
  const base::Pose X_WBoard = PlaceUsed() * X_LBoard;
  sighting.plane_W.normal = -X_WBoard.linear().col(2);  // the board's back is its z side
  sighting.plane_W.offset_m = -sighting.plane_W.normal.dot(X_WBoard.translation());
  return sighting;
}

std::vector<BoardSighting> Sightings(int views, double noise_px,
                                     const ChessboardOptions& options = {}) {
  base::Rng rng(3);
  std::vector<BoardSighting> sightings;
  for (int i = 0; i < views; ++i) {
    sightings.push_back(Sighting(BoardPlace(rng), options, noise_px, rng));
  }
  return sightings;
}

/// The largest error of an edge that is found in a picture of such spots. cornerSubPix weights each
/// pixel by the square of its grey value's slope, which is half the difference of its neighbors.
/// The middle of the sampled squares is not the edge.
double SharpEdgeBias() {
  const auto edge = [](double x) { return std::clamp(x / kSpot_px + 0.5, 0.0, 1.0); };
  constexpr int kPlaces = 1000;
  double worst = 0.0;
  for (int k = 0; k < kPlaces; ++k) {
    const double place = k / double{kPlaces};
    double weights = 0.0, sum = 0.0;
    for (int x = -5; x <= 5; ++x) {
      const double slope = 0.5 * (edge(x + 1 - place) - edge(x - 1 - place));
      weights += slope * slope;
      sum += slope * slope * (x - place);
    }
    worst = std::max(worst, std::abs(sum / weights));
  }
  return worst;
}

base::Pose BoardInFront() { return TurnedBy({0.3, -0.25, 0.1}, {-0.11, -0.06, 0.55}); }

/// A view with laser points on the board's plane and a few elsewhere. The laser is at the origin.
BoardView View(int blur_px, const ChessboardOptions& options = {}) {
  base::Rng rng(5);
  BoardView view;
  view.name = "view 3";
  view.left = BoardPicture(BoardInFront(), options, blur_px);
  view.right = BoardPicture(TurnedBy({0, 0.02, 0}, {-0.02, 0, 0}) * BoardInFront(), options, 1);
  view.laser_origin_W = Eigen::Vector3d::Zero();
  for (int i = 0; i < 1000; ++i) {
    const double x = rng.Uniform(-0.03, 0.25);
    const double y = rng.Uniform(-0.03, 0.15);
    const double z = (i % 20 == 0 ? 0.03 : 0.0003) * rng.Normal();
    view.laser_W.push_back(BoardInFront() * Eigen::Vector3d(x, y, z));
  }
  return view;
}

std::string Refusal(const std::vector<BoardSighting>& boards,
                    const ChessboardOptions& options = {}) {
  return ErrorOf([&] { CalibrateStereo(boards, 640, 480, options); });
}

// Compares equations 5.13 and 5.14 with the product of the poses.
TEST(RightInLeft, IsTheProductOfThePoses) {
  base::Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const base::Pose X_LB = TurnedBy({rng.Normal(), rng.Normal(), 0.3}, {rng.Normal(), 0.1, 1.0});
    const base::Pose X_RB = TurnedBy({rng.Normal(), -0.2, rng.Normal()}, {0.3, rng.Normal(), 1.0});
    EXPECT_TRUE(RightInLeft(X_LB, X_RB).isApprox(X_LB * X_RB.inverse(), 1e-12));
  }
}

TEST(FindBoard, FindsCornersAndTheLasersPlane) {
  const ChessboardOptions options;
  const BoardSighting found = FindBoard(View(1), options);
  const Camera camera = testing_support::BoardCamera();
  ASSERT_EQ(found.left_px.size(), 54u);
  double worst_px = 0.0;
  for (const Eigen::Vector2d& seen : found.left_px) {
    double nearest_px = 1e9;
    for (int i = 0; i < 54; ++i) {
      const Eigen::Vector3d corner(i % 9 * options.square_m, i / 9 * options.square_m, 0.0);
      nearest_px = std::min(nearest_px, (Project(camera, BoardInFront() * corner) - seen).norm());
    }
    worst_px = std::max(worst_px, nearest_px);
  }
  // Each of a corner's two coordinates comes from one edge. A row of that edge is off by at most
  // half the spacing of the picture's samples, plus OpenCV's error for a straight edge
  // (SharpEdgeBias). Together this is 0.076 px, and sqrt(2) times as much for both edges.
  EXPECT_LT(worst_px, std::sqrt(2.0) * (0.5 * kSpot_px / kParts + SharpEdgeBias()));
  const base::Pose X_WB = BoardInFront();
  EXPECT_NEAR(std::abs(found.plane_W.normal.dot(X_WB.linear().col(2))), 1.0, 1e-6);
  // Five standard errors of a thousand points with 0.3 mm noise.
  EXPECT_NEAR(found.plane_W.Distance(X_WB * Eigen::Vector3d(0.1, 0.06, 0)), 0.0, 5e-5);
  EXPECT_GT(found.plane_W.Distance(Eigen::Vector3d::Zero()), 0.0);
}

TEST(FindBoard, SaysWhatIsWrongWithAPicture) {
  const ChessboardOptions options;
  ChessboardOptions other = options;
  other.columns = 8;
  EXPECT_THAT(ErrorOf([&] { FindBoard(View(1), other); }),
              HasSubstr("view 3 (left): no chessboard with 8 x 6 inner corners"));
  EXPECT_THAT(ErrorOf([&] { FindBoard(View(7), options); }), HasSubstr("is blurred"));
  BoardView empty = View(1);
  std::fill(empty.right.rgb.begin(), empty.right.rgb.end(), std::uint8_t{120});
  EXPECT_THAT(ErrorOf([&] { FindBoard(empty, options); }), HasSubstr("view 3 (right): no chess"));
  BoardView unscanned = View(1);
  for (Eigen::Vector3d& p : unscanned.laser_W) p.z() += 0.5 * std::sin(1e5 * p.x());
  EXPECT_THAT(ErrorOf([&] { FindBoard(unscanned, options); }), HasSubstr("no plane of the board"));
}

TEST(StereoCalibrator, FindsTheLensTheTurnAndThePlace) {
  // Without noise the parameters are those that made the pictures, up to the single precision of
  // the corners (3e-5 px).
  const CalibrationResult exact = CalibrateStereo(Sightings(12, 0.0), 640, 480, {});
  EXPECT_NEAR(exact.calibration.camera.fx, LensUsed().fx, 0.02);
  EXPECT_NEAR(exact.calibration.camera.k1, LensUsed().k1, 1e-4);
  EXPECT_LT(exact.camera_px, 1e-3);
  EXPECT_TRUE(exact.calibration.X_WL.isApprox(PlaceUsed(), 1e-4));
  EXPECT_TRUE(exact.calibration.X_WR.isApprox(PlaceUsed() * TurnUsed(), 1e-4));
  EXPECT_LT(exact.calibration.registration_m, 1e-5);
}

// The residual comes from the noise of the corners. It is sigma sqrt(2) in the plane, reduced by
// the share of 9 + 6 n parameters in 4 * 54 n coordinates.
TEST(StereoCalibrator, ReportsTheNoiseOfTheCorners) {
  const CalibrationResult noisy = CalibrateStereo(Sightings(12, 0.1), 640, 480, {});
  EXPECT_NEAR(noisy.camera_px, 0.141, 0.01);
  EXPECT_NEAR(noisy.stereo_px, 0.141, 0.01);
  EXPECT_EQ(noisy.calibration.reprojection_px, std::max(noisy.camera_px, noisy.stereo_px));
  // A corner with 0.1 px noise is triangulated to z^2 / (f b) 0.14 px = 3.6 mm at 0.65 m.
  EXPECT_GT(noisy.triangulated_m, 0.001);
  EXPECT_LT(noisy.triangulated_m, 0.006);
}

// Boards with squares of 25 mm that are stated as 25.5 mm: all lengths come out 2 % too large.
TEST(StereoCalibrator, TellsSquaresOfAnotherSizeByTheLasersPlanes) {
  const CalibrationResult right = CalibrateStereo(Sightings(12, 0.05), 640, 480, {});
  EXPECT_LT(std::abs(right.scale - 1.0), std::max(0.001, 4.0 * right.scale_error));
  ChessboardOptions said;
  said.square_m = 0.0255;
  EXPECT_THAT(Refusal(Sightings(12, 0.05), said), ContainsRegex("fit squares of 2(4.9|5.0). mm"));
}

TEST(StereoCalibrator, GivesTheSameTwice) {
  const CalibrationResult a = CalibrateStereo(Sightings(8, 0.1), 640, 480, {});
  const CalibrationResult b = CalibrateStereo(Sightings(8, 0.1), 640, 480, {});
  EXPECT_EQ(a.calibration.camera, b.calibration.camera);
  EXPECT_EQ(a.calibration.X_WL.matrix(), b.calibration.X_WL.matrix());
}

TEST(StereoCalibrator, RefusesBoardsThatDoNotCalibrate) {
  EXPECT_THAT(Refusal(Sightings(5, 0.1)), HasSubstr("5 views of the chessboard"));
  auto alike = Sightings(8, 0.1);
  for (BoardSighting& board : alike) board.plane_W.normal = alike.front().plane_W.normal;
  EXPECT_THAT(Refusal(alike), HasSubstr("tilted too little"));
  EXPECT_THAT(Refusal(Sightings(8, 0.5)), HasSubstr("a reprojection error of"));
  ChessboardOptions larger;
  larger.square_m = 0.03;
  EXPECT_THAT(Refusal(Sightings(8, 0.05), larger), HasSubstr("are its squares 30 mm"));
  auto moved = Sightings(8, 0.05);
  moved[2].plane_W.offset_m += 0.02;
  EXPECT_THAT(Refusal(moved), HasSubstr("off the laser's planes"));
}

}  // namespace
}  // namespace rangegrasp::stereo
