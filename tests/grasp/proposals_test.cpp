#include "grasp/proposals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "grasp/fixtures.h"

namespace rangegrasp::grasp {
namespace {

using namespace rangegrasp::grasp::test;

// A proposal from above, 60 mm above the table; the x axis of G is that of C.
Proposal FromAbove(double width_m) {
  Proposal proposal;
  proposal.X_CG = base::MakePose(Vector3d(1.0, -1.0, -1.0).asDiagonal(), {0.1, -0.2, 0.06});
  proposal.width_m = width_m;
  return proposal;
}

TEST(PlaceHand, BringsThePadsTogetherAboutThePosition) {
  for (const double width_m : {0.02, 0.05, 0.08}) {
    const Grasp grasp = PlaceHand(FromAbove(width_m), Hand(), {});
    const auto& held = Hand().AtGap(width_m);
    const Vector3d thumb = grasp.X_CH * held.thumb_pad_H;
    const Vector3d fingers = grasp.X_CH * held.finger_pad_H;
    EXPECT_NEAR((0.5 * (thumb + fingers) - Vector3d(0.1, -0.2, 0.06)).norm(), 0.0, 1e-12);
    EXPECT_GT(thumb.x(), fingers.x()) << "x points from the fingers to the thumb";
    EXPECT_GT(grasp.opening_m, width_m + 0.015) << "20 mm wider, to the state at or above it";
    EXPECT_FALSE(grasp.collides);
  }
  EXPECT_TRUE(PlaceHand(FromAbove(Hand().MaxGap() + 0.001), Hand(), {}).collides);
}

// A symmetric box filled with points, on a table 20 mm below the origin, rotated by 0.4 rad about
// the vertical.
geometry::Points BoxOnTable(const Vector3d& size_m) {
  const base::Pose X = At(0.1, -0.2, 0.4);
  constexpr int kSteps = 8;
  geometry::Points points;
  for (int i = 0; i < 729; ++i) {
    const Vector3d share = Vector3d(i % 9, i / 9 % 9, i / 81) / kSteps;
    points.push_back(
        X * (size_m.cwiseProduct(share - Vector3d(0.5, 0.5, 0.0)) - 0.02 * Vector3d::UnitZ()));
  }
  return points;
}
const geometry::Plane kTable{Vector3d::UnitZ(), 0.02};

TEST(ProposeStraightDown, ClosesAcrossTheShorterSideOverTheMiddleEitherWay) {
  const auto ways = ProposeStraightDown(BoxOnTable({0.06, 0.03, 0.1}), kTable);
  ASSERT_EQ(ways.size(), 2u);
  const Vector3d short_side(-std::sin(0.4), std::cos(0.4), 0.0);
  for (const Proposal& way : ways) {
    const Eigen::Matrix3d R = way.X_CG.linear();
    EXPECT_NEAR(std::abs(R.col(0).dot(short_side)), 1.0, 1e-12);
    EXPECT_NEAR((R.col(2) + Vector3d::UnitZ()).norm(), 0.0, 1e-12);
    EXPECT_NEAR((way.approach_C - R.col(2)).norm(), 0.0, 1e-12);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
    EXPECT_NEAR(way.width_m, 0.03, 1e-12);
    // The grasp is 30 mm below the top, which is 80 mm above the origin.
    EXPECT_NEAR((way.X_CG.translation() - Vector3d(0.1, -0.2, 0.05)).norm(), 0.0, 1e-12);
  }
  EXPECT_NEAR(ways[0].X_CG.linear().col(0).dot(ways[1].X_CG.linear().col(0)), -1.0, 1e-12);
}

TEST(ProposeStraightDown, StaysAboveTheTableOnWhatIsLow) {
  // The pads are 10 mm above the table, or at half the height of objects lower than 20 mm.
  for (const auto& [height_m, pads_m] : {std::pair{0.025, 0.010}, {0.016, 0.008}}) {
    const auto ways = ProposeStraightDown(BoxOnTable({0.06, 0.03, height_m}), kTable);
    EXPECT_NEAR(ways.at(0).X_CG.translation().z(), pads_m - 0.02, 1e-9);
  }
  EXPECT_TRUE(ProposeStraightDown({}, kTable).empty());
}

TEST(BetweenFingers, AreThePointsThatTheHandReachesRound) {
  const Grasp grasp = PlaceHand(FromAbove(0.05), Hand(), {});
  const Vector3d at(0.1, -0.2, 0.06);
  const geometry::Points points = {at,
                                   at + Vector3d(0.02, 0.0, 0.0),
                                   at + Vector3d(-0.02, 0.01, 0.01),
                                   at + Vector3d(0.2, 0.0, 0.0),   // beyond the thumb
                                   at + Vector3d(0.0, 0.1, 0.0),   // next to the fingers
                                   at + Vector3d(0.0, 0.0, -0.1),  // below their tips
                                   at + Vector3d(0.0, 0.0, 0.3)};  // above the palm
  EXPECT_EQ(BetweenFingers(grasp, Hand(), points), (geometry::Indices{0, 1, 2}));
  EXPECT_TRUE(BetweenFingers(grasp, Hand(), {}).empty());
}

/// Half a ring with radius 28 mm about (38, 0, 0) mm in the plane y = 0 and a bar 9 mm thick,
/// rotated about the vertical. Only the side seen from -y.
geometry::Points HalfRing(double turn_rad) {
  const Eigen::AngleAxisd X(turn_rad, Vector3d::UnitZ());
  geometry::Points points;
  for (double along = -1.5; along <= 1.5; along += 0.05) {
    const Vector3d radial(std::cos(along), 0.0, std::sin(along));
    for (double round = base::kPi; round <= 2.0 * base::kPi; round += 0.2) {
      const Vector3d p = Vector3d(0.038, 0.0, 0.0) + 0.028 * radial +
                         0.0045 * (std::cos(round) * radial + std::sin(round) * Vector3d::UnitY());
      points.emplace_back(X * p);
    }
  }
  return points;
}

TEST(HandleGrasps, CloseAcrossTheBarWhereItIsFarthestOut) {
  for (int k = 0; k < 8; ++k) {
    const double turn = 0.8 * k;
    const Eigen::AngleAxisd X(turn, Vector3d::UnitZ());
    const geometry::Points points = HalfRing(turn);
    const auto ways = ProposeHandleGrasps(points, Vector3d(0.0, 0.0, 0.01), Vector3d::UnitZ());
    ASSERT_GE(ways.size(), 8u);
    for (const Proposal& way : ways) {
      const Vector3d closing = X.inverse() * way.X_CG.linear().col(0);
      EXPECT_GT(std::abs(closing.y()), 0.99);
      const Vector3d at = X.inverse() * way.X_CG.translation();
      // The bar's center is at 66 mm; its seen half is 2 to 4 mm to the side.
      EXPECT_NEAR(at.x(), 0.064, 0.005);
      EXPECT_NEAR(at.y(), -0.002, 0.003);
      // The body's center is 10 mm higher, so the outward direction leans by 10 deg: 5 mm along a
      // ring of 28 mm.
      EXPECT_NEAR(at.z(), -0.005, 0.002);
      EXPECT_GE(way.width_m, 0.008);
      EXPECT_LT(way.width_m, 0.010);
    }
  }
}

TEST(HandleGrasps, ComeFromAboveOrLevelAndNotThroughTheBody) {
  const geometry::Points points = HalfRing(0.0);
  const auto ways = ProposeHandleGrasps(points, Vector3d::Zero(), Vector3d::UnitZ());
  ASSERT_FALSE(ways.empty());
  EXPECT_LT(ways.front().approach_C.z(), -0.95);  // steepest first
  for (std::size_t i = 0; i < ways.size(); ++i) {
    EXPECT_LT(ways[i].approach_C.z(), 0.18);
    EXPECT_LT(ways[i].approach_C.x(), 0.11);
    EXPECT_NEAR((ways[i].approach_C - ways[i].X_CG.linear().col(2)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(ways[i].X_CG.linear().determinant(), 1.0, 1e-9);
    if (i > 0) {
      EXPECT_GE(ways[i].approach_C.z(), ways[i - 1].approach_C.z() - 1e-9);
    }
  }
}

TEST(HandleGrasps, OfTwoPointsThereAreNone) {
  const geometry::Points two(2, Vector3d::UnitX());
  EXPECT_TRUE(ProposeHandleGrasps(two, Vector3d::Zero(), Vector3d::UnitZ()).empty());
}

}  // namespace
}  // namespace rangegrasp::grasp
