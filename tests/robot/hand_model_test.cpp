#include <gtest/gtest.h>

#include "base/units.h"
#include "robot/test_cells.h"

namespace rangegrasp::robot {
namespace {

class Hand : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  Hand() : robot_(Robot::Load(GetParam())), hand_(robot_.hand()) {}
  Robot robot_;
  const HandModel& hand_;
};

TEST_P(Hand, ClosesFromOpenUntilThePadsTouchOrTheJointsEnd) {
  ASSERT_GE(hand_.states.size(), 23u);
  EXPECT_EQ(hand_.states.front().closing, 0.0);
  EXPECT_EQ(hand_.states.back().closing, 1.0);
  for (std::size_t i = 1; i < hand_.states.size(); ++i) {
    EXPECT_LT(hand_.states[i].gap_m, hand_.states[i - 1].gap_m);
    EXPECT_GT(hand_.states[i].closing, hand_.states[i - 1].closing);
  }
  EXPECT_LT(hand_.states.back().gap_m, 1e-6);
}

TEST_P(Hand, PadsMeetWhenClosedAndOpenAlongTheClosingDirection) {
  const auto& closed = hand_.states.back();
  const auto& open = hand_.states.front();
  // Means over the fingers' points: up to half the fingers' spacing apart.
  EXPECT_LT((closed.thumb_pad_H - closed.finger_pad_H).norm(), 0.01);
  const Eigen::Vector3d opening = (open.thumb_pad_H - open.finger_pad_H).normalized();
  EXPECT_GT(opening.dot(hand_.X_HG_tip.linear().col(0)), 0.95);
}

// The published tool centres lie between the tips: midway between both sides of the hand at every
// opening, and at the sites of the open hand but for the row that its fingers stand in.
TEST_P(Hand, ToolCentresMoveWithTheOpening) {
  for (const auto& state : hand_.states) {
    for (const Eigen::Vector3d& center : {state.tip_center_H, state.power_center_H}) {
      const Eigen::Vector3d pads = 0.5 * (state.thumb_pad_H + state.finger_pad_H);
      const Eigen::Vector3d closing = hand_.X_HG_tip.linear().col(0);
      // A thumb's tip is longer than its pad, and the little finger stops before the others.
      EXPECT_LT(std::abs((center - pads).dot(closing)), 0.008);
    }
  }
  const auto shift = [&](const Eigen::Vector3d& to) {
    return (to - hand_.states.front().tip_center_H).norm();
  };
  EXPECT_GT(shift(hand_.states.back().tip_center_H), 0.001);
}

TEST_P(Hand, AtGapGivesTheTightestStateThatIsWideEnough) {
  for (double gap_m = 0.0; gap_m < hand_.MaxGap(); gap_m += 0.0013) {
    const auto& state = hand_.AtGap(gap_m);
    EXPECT_GE(state.gap_m, gap_m);
    for (const auto& other : hand_.states) {
      EXPECT_FALSE(other.gap_m >= gap_m && other.gap_m < state.gap_m);
    }
  }
  EXPECT_EQ(&hand_.AtGap(1.0), &hand_.states.front());
}

TEST_P(Hand, AStatesOwnGapIsWideEnough) {
  for (std::size_t i = 0; i < hand_.states.size(); ++i) {
    EXPECT_EQ(hand_.IndexAtGap(hand_.states[i].gap_m), i);
  }
}

TEST_P(Hand, StatesThatDifferAreRefused) {
  EXPECT_NO_THROW(CheckStates(hand_));
  EXPECT_THROW(CheckStates(HandModel()), std::invalid_argument);
  HandModel shapes = hand_, fingers = hand_, thumbs = hand_;
  shapes.states[1].shapes.pop_back();
  fingers.states[1].is_finger.pop_back();
  thumbs.states[1].is_thumb.pop_back();
  for (const HandModel& hand : {shapes, fingers, thumbs}) {
    EXPECT_THROW(CheckStates(hand), std::invalid_argument);
  }
}

TEST_P(Hand, ThumbShapesAreFingersAndEveryShapeIsFlagged) {
  for (const auto& state : hand_.states) {
    ASSERT_EQ(state.is_finger.size(), state.shapes.size());
    ASSERT_EQ(state.is_thumb.size(), state.shapes.size());
    int thumbs = 0;
    for (std::size_t i = 0; i < state.shapes.size(); ++i) {
      EXPECT_LE(state.is_thumb[i], state.is_finger[i]);
      thumbs += state.is_thumb[i];
    }
    EXPECT_GT(thumbs, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, Hand, ::testing::ValuesIn(Cells()),
                         [](const auto& cell) { return CellName(cell.param); });

// Finger and thumb are mirror images, hinged at x = -+0.055, turned out by 5 deg; their axes are
// 0.095 m long with radius 0.008, the finger's last segment being the outer 0.045 m. Turned in by
// a, the tips' ends are nearest; turned out, the start of the finger's last segment is, and the
// nearest point of the thumb's axis is the foot of the perpendicular.
TEST(SmallHand, GapFollowsFromTheHinges) {
  const Robot robot = Robot::Load(SmallCell());
  for (const auto& state : robot.hand().states) {
    const double touch = std::asin((0.055 - 0.008) / 0.095);  // tips' axes 0.016 apart
    const double angle = state.closing * (touch + base::Deg(5)) - base::Deg(5);
    const double axes = angle > 0.0
                            ? 2.0 * (0.055 - 0.095 * std::sin(angle))
                            : 0.11 * std::cos(angle) - 0.1 * std::sin(angle) * std::cos(angle);
    const double expected = axes - 0.016;
    EXPECT_NEAR(state.gap_m, expected, 2e-6) << state.closing;
  }
}

TEST(SmallHand, PassiveFingerFollowsItsSpringUpToItsLimit) {
  const Robot robot = Robot::Load(SmallCell());
  const double closed = std::asin((0.055 - 0.008) / 0.095) + base::Deg(5);
  for (const auto& state : robot.hand().states) {
    const double turn = std::min(state.closing * closed, base::Deg(30)) - base::Deg(5);
    const Eigen::Vector3d along(std::sin(turn), 0.0, std::cos(turn));
    for (const auto& shape : state.shapes) {
      if (shape.name != "passive") continue;
      EXPECT_NEAR(std::abs(shape.X_BS.linear().col(2).dot(along)), 1.0, 1e-9);
    }
  }
}

TEST(SmallHand, DepthReachesFromThePalmToTheToolCentre) {
  EXPECT_NEAR(Robot::Load(SmallCell()).hand().depth_m, 0.12 - 0.02, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::robot
