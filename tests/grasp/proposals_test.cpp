#include "grasp/proposals.h"

#include <gtest/gtest.h>

#include "grasp/fixtures.h"

namespace rangegrasp::grasp {
namespace {

using namespace rangegrasp::grasp::test;

// From above, 60 mm over the table; x of G is x of C.
Proposal FromAbove(double width_m) {
  Proposal proposal;
  proposal.X_CG = base::MakePose(Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(), {0.1, -0.2, 0.06});
  proposal.width_m = width_m;
  return proposal;
}

TEST(PlaceHand, BringsThePadsTogetherAboutThePosition) {
  const robot::HandModel& hand = SensorHand();
  for (const double width_m : {0.02, 0.05, 0.08}) {
    const Grasp grasp = PlaceHand(FromAbove(width_m), hand, {});
    const auto& held = hand.AtGap(width_m);
    const Eigen::Vector3d thumb = grasp.X_CH * held.thumb_pad_H;
    const Eigen::Vector3d fingers = grasp.X_CH * held.finger_pad_H;
    EXPECT_NEAR((0.5 * (thumb + fingers) - Eigen::Vector3d(0.1, -0.2, 0.06)).norm(), 0.0, 1e-12);
    EXPECT_GT(thumb.x(), fingers.x()) << "x points from the fingers to the thumb";
    EXPECT_GT(grasp.opening_m, width_m + 0.015) << "20 mm wider, to the state at or above it";
    EXPECT_FALSE(grasp.collides);
  }
  EXPECT_TRUE(PlaceHand(FromAbove(hand.MaxGap() + 0.001), hand, {}).collides);
}

TEST(BetweenFingers, AreThePointsThatTheHandReachesRound) {
  const robot::HandModel& hand = SensorHand();
  const Grasp grasp = PlaceHand(FromAbove(0.05), hand, {});
  const Eigen::Vector3d at(0.1, -0.2, 0.06);
  const geometry::Points points = {at,
                                   at + Eigen::Vector3d(0.02, 0.0, 0.0),
                                   at + Eigen::Vector3d(-0.02, 0.01, 0.01),
                                   at + Eigen::Vector3d(0.2, 0.0, 0.0),   // beyond the thumb
                                   at + Eigen::Vector3d(0.0, 0.1, 0.0),   // beside the fingers
                                   at + Eigen::Vector3d(0.0, 0.0, -0.1),  // below their tips
                                   at + Eigen::Vector3d(0.0, 0.0, 0.3)};  // above the palm
  EXPECT_EQ(BetweenFingers(grasp, hand, points), (geometry::Indices{0, 1, 2}));
  EXPECT_TRUE(BetweenFingers(grasp, hand, {}).empty());
}

}  // namespace
}  // namespace rangegrasp::grasp
