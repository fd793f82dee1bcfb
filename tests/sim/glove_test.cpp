#include "sim/internal/glove.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/scene_files.h"

namespace rangegrasp::sim::internal {
namespace {

// Two tips that hang over the plane, 0.4 m apart.
constexpr char kTwoTips[] = R"(<mujoco><option timestep="0.002" cone="elliptic" gravity="0 0 0"/>
<compiler autolimits="true"/>
<default><geom condim="4" priority="0"/></default>
<worldbody><body name="table"><geom type="plane" size="0 0 1"/></body>
  <body name="hand" pos="0 0 0.5"><geom name="palm" type="box" size="0.01 0.01 0.01" mass="1"/>
    <body name="thumb" pos="-0.2 0 0"><joint name="thumb" axis="0 1 0" range="-1 1"/>
      <geom name="thumb_tip" type="sphere" size="0.01" mass="0.1" priority="1"/></body>
    <body name="index" pos="0.2 0 0"><joint name="index" axis="0 1 0" range="-1 1"/>
      <geom name="index_tip" type="sphere" size="0.01" mass="0.1" priority="1"/></body>
  </body></worldbody>
<custom>
  <tuple name="hand_joints"><element objtype="joint" objname="thumb"/><element objtype="joint" objname="index"/></tuple>
  <tuple name="fingertips"><element objtype="geom" objname="thumb_tip"/><element objtype="geom" objname="index_tip"/></tuple>
</custom></mujoco>)";

class TwoTips : public ::testing::Test {
 protected:
  TwoTips()
      : world_(samples::WriteFile("two_tips.xml", kTwoTips), {Cube("cube"), Cube("other")}, {}) {
    base::Rng rng(7);
    world_.DrawFriction(rng);
  }

  static ObjectModel Cube(const std::string& name) {
    return samples::MakeObject(name, R"(<geom type="box" size="0.02 0.02 0.02" mass="0.3"/>)");
  }
  // Its upper side 0.2 mm inside the tip, at a speed along y.
  void Under(int object, double x, double speed_m_s = 0.0) {
    world_.PlaceObject(object, base::MakePose(Eigen::Matrix3d::Identity(), {x, 0.0, 0.4702}));
    world_.data()->qvel[world_.model()->nv - 12 + 6 * object + 1] = speed_m_s;
    mj_forward(world_.model(), world_.data());
  }
  double Friction(const char* geom) const {
    return world_.model()->geom_friction[3 * mj_name2id(world_.model(), mjOBJ_GEOM, geom)];
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

}  // namespace
}  // namespace rangegrasp::sim::internal
