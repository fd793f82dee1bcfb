#include "robot/internal/joint_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::robot::internal {
namespace {

using Eigen::VectorXd;

VectorXd At(double x, double y) { return Eigen::Vector2d(x, y); }

// A right angle: the arc of radius r leaves the corner by r (sqrt 2 - 1) and cuts r from both legs.
TEST(RoundCorners, RightAngleHasTheAnalyticArc) {
  const double corner_rad = 0.05;
  const double r = corner_rad / (std::sqrt(2.0) - 1.0);
  const auto pieces = RoundCorners({At(0, 0), At(1, 0), At(1, 2)}, corner_rad);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_NEAR(pieces[0].length, 1.0 - r, 1e-12);
  EXPECT_NEAR(pieces[1].length, 0.5 * base::kPi * r, 1e-12);
  EXPECT_NEAR(pieces[2].length, 2.0 - r, 1e-12);
  const VectorXd middle = pieces[1].Position(0.5 * pieces[1].length);
  EXPECT_NEAR((middle - At(1, 0)).norm(), corner_rad, 1e-12);
}

// A leg shorter than the arc would need: no more than half of it is cut.
TEST(RoundCorners, ShortLegsAreCutByHalfAtMost) {
  const auto pieces = RoundCorners({At(0, 0), At(0.02, 0), At(0.02, 1)}, 0.05);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_NEAR(pieces[0].length, 0.01, 1e-12);
}

TEST(RoundCorners, ReversalsStopAndStraightOrRepeatedPointsDoNot) {
  const auto reversal = RoundCorners({At(0, 0), At(1, 0), At(0.2, 0)}, 0.05);
  ASSERT_EQ(reversal.size(), 2u);
  EXPECT_FALSE(reversal[0].stop_before);
  EXPECT_TRUE(reversal[1].stop_before);
  const auto straight = RoundCorners({At(0, 0), At(1, 0), At(1, 0), At(3, 0)}, 0.05);
  double length = 0.0;
  for (const PathPiece& piece : straight) {
    length += piece.length;
    EXPECT_FALSE(piece.stop_before);
    EXPECT_EQ(piece.radius, 0.0);
  }
  EXPECT_NEAR(length, 3.0, 1e-12);
  EXPECT_TRUE(RoundCorners({At(1, 1), At(1, 1)}, 0.05).empty());
}

// In seven dimensions: one piece goes on where the last ends, in its direction; the derivatives are
// those of the position (by differences); no point is further than corner_rad from the polyline.
TEST(RoundCorners, RandomPathsAreSmoothAndNear) {
  base::Rng rng(3);
  for (int n = 0; n < 200; ++n) {
    std::vector<VectorXd> points;
    for (int i = 0; i < 5; ++i) {
      VectorXd q(7);
      for (double& value : q) value = rng.Uniform(-1.0, 1.0);
      points.push_back(q);
    }
    const auto pieces = RoundCorners(points, 0.05);
    EXPECT_LT((pieces.front().Position(0.0) - points.front()).norm(), 1e-12);
    EXPECT_LT((pieces.back().Position(pieces.back().length) - points.back()).norm(), 1e-9);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const PathPiece& piece = pieces[k];
      if (k > 0 && !piece.stop_before) {
        const PathPiece& last = pieces[k - 1];
        EXPECT_LT((last.Position(last.length) - piece.Position(0.0)).norm(), 1e-9);
        EXPECT_LT((last.Tangent(last.length) - piece.Tangent(0.0)).norm(), 1e-6);
      }
      const double s = 0.37 * piece.length;
      const double h = 1e-5 * piece.length;
      const VectorXd slope = (piece.Position(s + h) - piece.Position(s - h)) / (2.0 * h);
      const VectorXd bend = (piece.Tangent(s + h) - piece.Tangent(s - h)) / (2.0 * h);
      EXPECT_LT((slope - piece.Tangent(s)).norm(), 1e-6);
      EXPECT_LT((bend - piece.Curvature(s)).norm(), 1e-6 * (1.0 + bend.norm()));
      EXPECT_NEAR(piece.Tangent(s).norm(), 1.0, 1e-12);
      double distance = 1e9;
      for (std::size_t i = 1; i < points.size(); ++i) {
        const VectorXd leg = points[i] - points[i - 1];
        const double t =
            std::clamp((piece.Position(s) - points[i - 1]).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
        distance = std::min(distance, (piece.Position(s) - points[i - 1] - t * leg).norm());
      }
      EXPECT_LE(distance, 0.05 + 1e-12);
    }
  }
}

}  // namespace
}  // namespace rangegrasp::robot::internal
