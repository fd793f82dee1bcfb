#include "sim/internal/contacts.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <array>

#include "sim/scene_files.h"

namespace rangegrasp::sim::internal {
namespace {

// Two tips above the plane, 0.4 m apart.
constexpr char kTwoTips[] = R"(<mujoco><option timestep="0.002" cone="elliptic" gravity="0 0 0"/>
<compiler autolimits="true"/>
<default><geom condim="4" priority="0"/></default>
<worldbody><body name="table"><geom type="plane" size="0 0 1"/></body>
  <body name="hand" pos="0 0 0.5"><geom name="palm" type="box" size="0.01 0.01 0.01" mass="1"/>
    <body name="thumb" pos="-0.2 0 0"><joint name="thumb" axis="0 1 0" range="-1 1"/>
      <geom name="thumb_tip" type="sphere" size="0.01" mass="0.1" priority="1" solimp="0.95 0.99 0.001"/></body>
    <body name="index" pos="0.2 0 0"><joint name="index" axis="0 1 0" range="-1 1"/>
      <geom name="index_tip" type="sphere" size="0.01" mass="0.1" priority="1" solimp="0.95 0.99 0.001"/></body>
  </body></worldbody>
<custom>
  <tuple name="hand_joints"><element objtype="joint" objname="thumb"/><element objtype="joint" objname="index"/></tuple>
  <tuple name="fingertips"><element objtype="geom" objname="thumb_tip"/><element objtype="geom" objname="index_tip"/></tuple>
</custom></mujoco>)";

class TwoTips : public ::testing::Test {
 protected:
  TwoTips()
      : world_(samples::WriteFile("two_tips.xml", kTwoTips),
               {Cube("cube", 0.3), Cube("other", 0.3), Cube("light", 0.02)}, {}) {
    base::Rng rng(7);
    world_.DrawFriction(rng);
  }

  static ObjectModel Cube(const std::string& name, double mass_kg) {
    return samples::MakeObject(
        name, fmt::format(R"(<geom type="box" size="0.02 0.02 0.02" mass="{}"/>)", mass_kg));
  }
  // Places the object with its upper side 0.2 mm inside the tip and with a speed along y.
  void Under(int object, double x, double speed_m_s = 0.0) {
    world_.PlaceObject(object, base::MakePose(Eigen::Matrix3d::Identity(), {x, 0.0, 0.4702}));
    world_.data()->qvel[world_.model()->nv - 18 + 6 * object + 1] = speed_m_s;
    mj_forward(world_.model(), world_.data());
  }
  double Friction(const char* geom) const {
    return world_.model()->geom_friction[3 * mj_name2id(world_.model(), mjOBJ_GEOM, geom)];
  }

  // Share of a contact's softness, at its two ends, in that of the scene's file.
  std::array<double, 2> Softness(const char* geom) const {
    const mjtNum* solimp =
        world_.model()->geom_solimp + mjNIMP * mj_name2id(world_.model(), mjOBJ_GEOM, geom);
    return {(1.0 - solimp[0]) / (1.0 - 0.95), (1.0 - solimp[1]) / (1.0 - 0.99)};
  }

  World world_;
  HandGeoms hand_{world_.model()};
  Glove glove_{world_, hand_, 0};
};

TEST_F(TwoTips, EachThingTouchedHasItsOwnPair) {
  Under(0, -0.2);
  Under(1, 0.2);
  glove_.Tick(world_);
  EXPECT_EQ(Friction("thumb_tip"), world_.glove_friction(0).static_mu);
  EXPECT_EQ(Friction("index_tip"), world_.glove_friction(1).static_mu);
  EXPECT_FALSE(glove_.Slides());
}

TEST_F(TwoTips, WhatSlidesIsKineticAndTheOtherIsNot) {
  Under(0, -0.2, 0.05);
  Under(1, 0.2);
  glove_.Tick(world_);
  EXPECT_EQ(Friction("thumb_tip"), world_.glove_friction(0).kinetic_mu);
  EXPECT_EQ(Friction("index_tip"), world_.glove_friction(1).static_mu);
  EXPECT_TRUE(glove_.Slides());
}

TEST_F(TwoTips, AGeomThatTouchesNothingHasTheTargetsPair) {
  glove_.Tick(world_);
  EXPECT_EQ(Friction("thumb_tip"), world_.glove_friction(0).static_mu);
  EXPECT_EQ(Friction("index_tip"), world_.glove_friction(0).static_mu);
}

TEST_F(TwoTips, ALightObjectIsPressedInNoDeeperThanOneOf100Grams) {
  Under(2, -0.2);
  Under(1, 0.2);
  glove_.Tick(world_);
  for (const double share : Softness("thumb_tip")) EXPECT_NEAR(share, 0.2, 1e-9);  // 20 of 100 g
  for (const double share : Softness("index_tip")) EXPECT_NEAR(share, 1.0, 1e-9);
  Under(2, 5.0);
  Under(0, -0.2);
  Glove(world_, hand_, 0).Tick(world_);  // as the next approach begins
  for (const double share : Softness("thumb_tip")) EXPECT_NEAR(share, 1.0, 1e-9);
}

// The engine gives the side of a contact that is a flex no geom, but -1.
TEST_F(TwoTips, AFlexThatTouchesAnObjectIsNotTheHand) {
  Under(0, -0.2);
  Under(1, 0.2);
  for (int i = 0; i < world_.data()->ncon; ++i) {
    for (int& geom : world_.data()->contact[i].geom) geom = hand_.IsHand(geom) ? -1 : geom;
  }
  EXPECT_TRUE(ContactsOf(world_, hand_, 0).empty());
  EXPECT_EQ(PressureOn(world_, hand_, 0), 0.0);
  EXPECT_FALSE(TouchOf(world_, hand_, 0).hand);
  EXPECT_TRUE(TouchOf(world_, hand_, 0).other);
  EXPECT_NEAR(DeepestElsewhere(world_, hand_, 0), 0.0002, 1e-9);
}

HandControlOptions Quiet() {
  HandControlOptions options;
  options.slip_noise_m_s = 0.0;
  return options;
}

// Time at which a slide that begins at 0.1 s is first detected; 0 if not within a second.
double HeardAt(const HandControlOptions& options, double speed_m_s, double step_s) {
  SlipSensor sensor(options, base::Rng(3));
  for (int i = 0; i * step_s < 1.0; ++i) {
    const double time_s = i * step_s;
    if (sensor.Tick(time_s, time_s >= 0.1 ? speed_m_s : 0.0)) return time_s;
  }
  return 0.0;
}

// For any time step, a reading is taken every 8 ms and arrives 20 ms later.
TEST(SlipSensor, HearsWhatIsAboveTheThresholdAfterTheDelay) {
  for (const double step_s : {0.004, 0.002, 0.001}) {
    EXPECT_GE(HeardAt(Quiet(), 0.0021, step_s), 0.1 + 0.020) << step_s;
    EXPECT_LE(HeardAt(Quiet(), 0.0021, step_s), 0.1 + 0.020 + 0.008 + 1e-9) << step_s;
    EXPECT_EQ(HeardAt(Quiet(), 0.0019, step_s), 0.0) << step_s;
  }
}

TEST(SlipSensor, IsSilentAgainAfterTheSlide) {
  SlipSensor sensor(Quiet(), base::Rng(3));
  bool heard = false;
  for (int i = 0; i < 100; ++i) heard = sensor.Tick(0.002 * i, i < 50 ? 0.01 : 0.0);
  EXPECT_FALSE(heard);
}

// For a slide exactly at the threshold, half of the readings are above it. Without a slide, a
// reading must be 5 standard deviations off, once in 3.5 million.
TEST(SlipSensor, NoiseIsOfEachReading) {
  HandControlOptions options;
  options.slip_delay_s = 0.0;
  SlipSensor at_threshold(options, base::Rng(3));
  SlipSensor still(options, base::Rng(4));
  int heard = 0;
  int false_alarms = 0;
  for (int i = 0; i < 4000; ++i) {
    heard += at_threshold.Tick(0.008 * i, options.slip_threshold_m_s) ? 1 : 0;
    false_alarms += still.Tick(0.008 * i, 0.0) ? 1 : 0;
  }
  EXPECT_NEAR(heard, 2000, 4 * 32);  // four standard deviations of a binomial
  EXPECT_EQ(false_alarms, 0);
}

}  // namespace
}  // namespace rangegrasp::sim::internal
