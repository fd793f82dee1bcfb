#include "sim/internal/hand_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace rangegrasp::sim::internal {
namespace {

constexpr double kStep_s = 0.002;
const Eigen::Vector3d kWeight_H(0.0, 4.0, 0.0);
const HandReading kTurning{-0.5, 2.0};
const HandReading kPressed{-0.3, 0.0, 2.0, 2.0, false, kWeight_H};
const HandReading kSliding{-0.3, 0.0, 2.0, 2.0, true, kWeight_H};
const HandReading kPutDown{-0.3, 0.0, 2.0, 2.0};

/// A grip control with the hand's readings, step by step.
struct Script {
  HandControlOptions options;
  HandDrive drive;
  GripControl control{options, drive, kStep_s};
  double torque_Nm = 0.0;

  explicit Script(const HandControlOptions& o = {}, const HandDrive& d = {})
      : options(o), drive(d) {}

  void For(double seconds, const HandReading& reading) {
    for (double t = 0.5 * kStep_s; t < seconds; t += kStep_s) torque_Nm = control.Tick(reading);
  }
  bool Closing() const { return control.mode() == GripControl::Mode::kClosing; }
  /// Closes on an object with contact on both sides and waits for the first grip.
  void Grip() {
    control.Close();
    For(0.3, kTurning);
    For(0.5, kPressed);
  }
};

TEST(GripControl, ClosesAtTheTorqueOfItsFreeSpeedUntilBothSidesFeel) {
  Script hand;
  hand.control.Close();
  hand.For(0.2, kTurning);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 6.1 * 2.2);
  HandReading one_side = kTurning;
  one_side.thumb_N = 5.0;
  hand.For(0.2, one_side);
  EXPECT_TRUE(hand.Closing());
  hand.For(kStep_s, kPressed);
  EXPECT_FALSE(hand.Closing());
}

// An obstacle in the way of the moving hand feels at most the weakest grip, 10 N.
TEST(GripControl, TheMovingMotorStallsAtALimitedCurrent) {
  Script hand;
  HandReading stalled = kTurning;
  stalled.speed_rad_s = 0.0;
  hand.control.Close();
  hand.For(kStep_s, stalled);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 10.0 * 0.135);
  hand.control.Open();
  hand.For(kStep_s, stalled);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, -10.0 * 0.135);
  HandReading opening = kTurning;
  opening.speed_rad_s = -2.0;
  hand.For(kStep_s, opening);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, -6.1 * 2.2);
}

TEST(GripControl, AMotorWithoutDampingMovesAtThatCurrent) {
  Script hand({}, {.damping_Nm_s = 0.0});
  hand.control.Close();
  hand.For(0.1, kTurning);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 10.0 * 0.135);
}

TEST(GripControl, AStalledMotorGripsToo) {
  Script hand;
  hand.control.Close();
  HandReading stalled = kTurning;
  stalled.speed_rad_s = 0.01;
  hand.For(0.05, stalled);
  EXPECT_TRUE(hand.Closing());
  hand.For(kStep_s, kTurning);  // it moved again
  hand.For(0.05, stalled);
  EXPECT_TRUE(hand.Closing());
  hand.For(0.02, stalled);
  EXPECT_FALSE(hand.Closing());
}

TEST(GripControl, AStallBeforeAnOpeningDoesNotCountForTheNextClosing) {
  Script hand;
  HandReading stalled = kTurning;
  stalled.speed_rad_s = 0.01;
  hand.control.Close();
  hand.For(0.05, stalled);
  hand.control.Open();
  hand.control.Close();
  hand.For(0.05, stalled);
  EXPECT_TRUE(hand.Closing());
}

// A first grip may be weaker than the minimum of a moving hand, and so may be the strongest.
TEST(GripControl, AWeakFirstGripIsNotRaised) {
  Script weak({}, {.first_force_N = 5.0, .max_force_N = 40.0});
  weak.Grip();
  EXPECT_DOUBLE_EQ(weak.control.force_N(), 5.0);
  EXPECT_DOUBLE_EQ(weak.torque_Nm, 5.0 * 0.135);
  Script weakest({}, {.first_force_N = 4.0, .max_force_N = 4.0});
  weakest.Grip();
  weakest.For(1.0, kSliding);
  EXPECT_DOUBLE_EQ(weakest.control.force_N(), 4.0);
}

TEST(GripControl, TheForceIsNeverBelowTheMinimum) {
  HandControlOptions options;
  options.min_force_N = 8.0;
  Script hand(options, {.first_force_N = 9.0});
  hand.control.Close();
  hand.For(kStep_s, kPressed);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 8.0);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 8.0 * 0.135);
}

// From the force for moving, the force rises at 250 N/s: 20 N after 0.04 s.
TEST(GripControl, TheForceRisesToTheFirstGripAndStays) {
  Script hand;
  hand.control.Close();
  hand.For(kStep_s, kPressed);
  double before_N = hand.control.force_N();
  EXPECT_DOUBLE_EQ(before_N, 10.0);
  for (int i = 0; i < 100; ++i) {
    hand.For(kStep_s, kPressed);
    EXPECT_GE(hand.control.force_N(), before_N);
    EXPECT_LE(hand.control.force_N(), before_N + 0.5 + 1e-9);
    before_N = hand.control.force_N();
    if (i == 18) {
      EXPECT_LT(before_N, 20.0);
    }
  }
  EXPECT_TRUE(hand.control.Gripping());
  hand.For(2.0, kPressed);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 20.0);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 20.0 * 0.135);
}

TEST(GripControl, EachSlipAddsItsGainOnceAPeriod) {
  Script hand;
  hand.Grip();
  hand.For(kStep_s, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 30.0);
  hand.For(0.030, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 30.0);  // the same slip, within 40 ms
  hand.For(0.012, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 40.0);
  hand.For(1.0, kPressed);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 40.0);  // and it stays when the object is held
  EXPECT_EQ(hand.control.slips_heard(), 2);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 40.0 * 0.135);
}

// As in the prosthesis: the object has been put down or is supported from below.
TEST(GripControl, TheForceReturnsToTheFirstGripWhenTheLoadIsGone) {
  HandReading pushed = kPutDown;
  pushed.load_H = -3.0 * kWeight_H;
  for (const HandReading& gone : {kPutDown, pushed}) {
    Script hand;
    hand.Grip();
    hand.For(0.5, kSliding);
    const double raised_N = hand.control.force_N();
    ASSERT_GT(raised_N, 90.0);
    hand.For(0.09, gone);  // contacts can chatter
    EXPECT_DOUBLE_EQ(hand.control.force_N(), raised_N);
    hand.For(0.1, kPressed);
    EXPECT_DOUBLE_EQ(hand.control.force_N(), raised_N);
    hand.For(0.5, gone);
    EXPECT_DOUBLE_EQ(hand.control.force_N(), 20.0);
    hand.For(kStep_s, kSliding);  // slips are detected as before
    EXPECT_DOUBLE_EQ(hand.control.force_N(), 30.0);
  }
}

TEST(GripControl, SlipWhileTheFirstGripIsReachedIsNotHeard) {
  Script hand;
  hand.control.Close();
  hand.For(0.09, kSliding);  // 22 steps of rise, 25 until slip counts
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 20.0);
  hand.For(0.01, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 30.0);
}

TEST(GripControl, WithoutSlipControlTheForceStays) {
  HandControlOptions options;
  options.slip_control = false;
  Script hand(options);
  hand.Grip();
  hand.For(1.0, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 20.0);
}

TEST(GripControl, NoSlipRaisesTheForceAboveTheMaximum) {
  Script hand({}, {.max_force_N = 75.0});
  hand.Grip();
  hand.For(5.0, kSliding);
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 75.0);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, 75.0 * 0.135);
}

TEST(GripControl, TheNextClosingBeginsWithTheFirstGripAgain) {
  Script hand;
  hand.Grip();
  hand.For(0.5, kSliding);
  ASSERT_GT(hand.control.force_N(), 90.0);
  hand.control.Open();
  hand.For(kStep_s, kTurning);
  EXPECT_EQ(hand.control.force_N(), 0.0);
  EXPECT_DOUBLE_EQ(hand.torque_Nm, -10.0 * 0.135);  // it was still closing
  hand.Grip();
  EXPECT_DOUBLE_EQ(hand.control.force_N(), 20.0);
}

// A ramp from -0.7 to -0.2 at 2.2 rad/s takes 0.227 s; the torque follows from the error to the
// ramp.
TEST(GripControl, PreshapesAtTheClosingSpeed) {
  Script hand;
  hand.control.Preshape(-0.7, -0.2);
  HandReading still;
  still.angle_rad = -0.7;
  hand.For(0.1, still);
  EXPECT_NEAR(hand.torque_Nm, 152.5 * 0.22, 1e-9);
  hand.For(0.5, still);
  EXPECT_NEAR(hand.torque_Nm, 152.5 * 0.5, 1e-9);
  EXPECT_FALSE(hand.control.Ratchets());
}

TEST(GripControl, RatchetsWhileItClosesAndGripsOnly) {
  Script hand;
  EXPECT_FALSE(hand.control.Ratchets());
  hand.control.Close();
  EXPECT_TRUE(hand.control.Ratchets());
  hand.For(1.0, kPressed);
  EXPECT_TRUE(hand.control.Ratchets());
  hand.control.Open();
  EXPECT_FALSE(hand.control.Ratchets());
}

// For any joint motion, the lower limit never falls and is never above the range. It is above the
// angle minus the backlash only if the joint came back.
TEST(Ratchet, FollowsTheAngleUpAndNeverFalls) {
  const std::vector<double> angles = {-0.7, -0.5, -0.3, -0.31, -0.6, -0.2, 0.1, -0.7};
  double lower = -0.75;
  double top = -0.75;
  for (const double angle : angles) {
    const double next = Ratchet(lower, 0.0, angle, 0.008);
    EXPECT_GE(next, lower);
    EXPECT_LE(next, 0.0);
    top = std::max(top, angle);
    EXPECT_DOUBLE_EQ(next, std::min(top - 0.008, 0.0));
    lower = next;
  }
}

}  // namespace
}  // namespace rangegrasp::sim::internal
