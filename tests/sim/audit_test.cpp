#include "sim/internal/audit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "base/units.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim::internal {
namespace {

using ::testing::StartsWith;

// A weightless hand with a palm and two tips on a slide, far above the plane. Its two joints are
// coupled one to one.
constexpr char kHandScene[] = R"(<mujoco><option timestep="0.002" integrator="implicitfast"/>
<compiler autolimits="true"/>
<worldbody><body name="table"><geom type="plane" size="0 0 1"/></body>
  <body name="link" pos="0 0 2" gravcomp="1">
    <joint name="slide" type="slide" axis="0 0 1" range="-1 1" actuatorfrcrange="-5 5"/>
    <body name="hand" gravcomp="1"><geom name="palm" type="box" size="0.05 0.05 0.05" mass="1"/>
      <body name="thumb" pos="-0.2 0 0" gravcomp="1"><joint name="thumb" axis="0 1 0" range="-1 1"/>
        <geom name="thumb_tip" type="sphere" size="0.01" mass="0.1"/></body>
      <body name="index" pos="0.2 0 0" gravcomp="1"><joint name="index" axis="0 1 0" range="-1 1"/>
        <geom name="index_tip" type="sphere" size="0.01" mass="0.1"/></body>
    </body></body></worldbody>
<equality><joint joint1="thumb" joint2="index" polycoef="0 1 0 0 0"/></equality>
<actuator><position name="servo" joint="slide" kp="1000" dampratio="1"/></actuator>
<custom>
  <tuple name="arm_joints"><element objtype="joint" objname="slide"/></tuple>
  <tuple name="arm_actuators"><element objtype="actuator" objname="servo"/></tuple>
  <tuple name="hand_joints"><element objtype="joint" objname="thumb"/><element objtype="joint" objname="index"/></tuple>
  <tuple name="fingertips"><element objtype="geom" objname="thumb_tip"/><element objtype="geom" objname="index_tip"/></tuple>
</custom></mujoco>)";

// Only the beam's ends, so that nothing between them hits the palm.
constexpr char kBeam[] = R"(
  <geom type="box" pos="-0.187 0 0" size="0.005 0.005 0.005" mass="0.15"/>
  <geom type="box" pos="0.187 0 0" size="0.005 0.005 0.005" mass="0.15"/>)";

constexpr double kMass_kg = 0.3;

class AuditBound : public ::testing::Test {
 protected:
  AuditBound()
      : world_(
            samples::WriteFile("audit_hand.xml", kHandScene),
            {samples::MakeObject("cube", R"(<geom type="box" size="0.02 0.02 0.02" mass="0.3"/>)"),
             samples::MakeObject("beam", kBeam)},
            {}) {
    Place(0.0, 0.0, 1.0);  // between hand and plane, touching neither
  }

  void Place(double x, double y, double z, double turn_rad = 0.0) {
    world_.PlaceObject(
        0, base::MakePose(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                          {x, y, z}));
  }
  void Forward() { mj_forward(world_.model(), world_.data()); }

  /// Checks the recorded figures with bounds around one figure's value: within the bound they pass,
  /// beyond it they fail and name this figure.
  void ExpectFailsBeyond(const std::string& figure, double value, double AuditBounds::*bound) {
    AuditBounds bounds;
    for (double AuditBounds::*other : kAll) bounds.*other = 1e9;
    bounds.*bound = 1.001 * value;
    EXPECT_EQ(audit_.Finish(bounds, true, true).failed, "");
    bounds.*bound = 0.999 * value;
    EXPECT_THAT(audit_.Finish(bounds, true, true).failed, StartsWith(figure + " "));
  }

  static constexpr double AuditBounds::*kAll[] = {
      &AuditBounds::penetration_p95_m, &AuditBounds::penetration_max_m,
      &AuditBounds::penetration_share, &AuditBounds::creep_m_s,
      &AuditBounds::equality_share,    &AuditBounds::energy_gain_m,
      &AuditBounds::drive_limit_s,     &AuditBounds::tracking_error_rad,
      &AuditBounds::grip_share,        &AuditBounds::creep_rad_s,
      &AuditBounds::unrest_s,          &AuditBounds::elsewhere_p95_m,
      &AuditBounds::elsewhere_max_m};

  void Step(bool holding) {
    JointCommand command;
    command.position = command.velocity = Eigen::VectorXd::Constant(1, commanded_m_);
    audit_.Step(holding, &command);
  }
  /// The cube rests for 0.4 s below the thumb's tip, which it penetrates by 0.1 mm.
  void RestUnderTheThumb() {
    Place(-0.2, 0.0, 2.0 - 0.01 - 0.02 + 1e-4);
    Forward();
    audit_.BeginRest();
    world_.data()->time += 0.4;
  }

  double commanded_m_ = 0.0;  // slide position

  World world_;
  HandGeoms hand_{world_.model()};
  ArmServo servo_{world_.model()};
  AuditRecorder audit_{world_, hand_, servo_, 0};
};

TEST_F(AuditBound, NothingRecordedIsValid) { EXPECT_EQ(audit_.Finish({}, true, true).failed, ""); }

// The cube is below the palm, deeper with each step. Of 100 steps, the 95th gives the p95.
TEST_F(AuditBound, Penetration) {
  for (int i = 1; i <= 100; ++i) {
    Place(0.0, 0.0, 2.0 - 0.05 - 0.02 + 1e-5 * i);
    Forward();
    Step(/*holding=*/true);
  }
  Place(0.0, 0.0, 2.0 - 0.05 - 0.02 + 0.01);
  Forward();
  Step(/*holding=*/false);  // deeper, but released
  const Audit audit = audit_.Finish({}, true, true);
  EXPECT_NEAR(audit.penetration_max_m, 1e-3, 1e-9);
  EXPECT_NEAR(audit.penetration_p95_m, 0.95e-3, 1e-9);
  ExpectFailsBeyond("penetration_p95_m", 0.95e-3, &AuditBounds::penetration_p95_m);
  ExpectFailsBeyond("penetration_max_m", 1e-3, &AuditBounds::penetration_max_m);
}

// The object moves by 0.1 mm in 0.4 s and turns by 0.002 rad about the contact.
TEST_F(AuditBound, Creep) {
  RestUnderTheThumb();
  Place(-0.2, 1e-4, 2.0 - 0.01 - 0.02 + 1e-4, 0.002);
  audit_.EndRest(0.0);
  ExpectFailsBeyond("creep_m_s", 1e-4 / 0.4, &AuditBounds::creep_m_s);
  ExpectFailsBeyond("creep_rad_s", 0.005, &AuditBounds::creep_rad_s);
  EXPECT_EQ(audit_.Finish({}, true, false).failed, "");  // lost in the carry: nothing was held
}

// The position of the object's origin does not matter: a turn about a contact moves a far origin,
// but no contact.
TEST_F(AuditBound, CreepIsThatOfTheContacts) {
  RestUnderTheThumb();
  const double turn_rad = 1e-4;
  const Eigen::Vector3d contact(-0.2, 0.0, 1.99);
  const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d center(-0.2, 0.0, 2.0 - 0.01 - 0.02 + 1e-4);
  world_.PlaceObject(0,
                     base::MakePose(turn.toRotationMatrix(), contact + turn * (center - contact)));
  audit_.EndRest(0.0);
  EXPECT_LT(audit_.Finish({}, true, true).creep_m_s, 1e-4 * turn_rad / 0.4 + 1e-9);
  EXPECT_GT(audit_.Finish({}, true, true).creep_rad_s, 0.9 * turn_rad / 0.4);
}

// Sliding before the restart does not count; creep after it and the time of sliding do.
TEST_F(AuditBound, TheRestBeginsAnewWhereTheObjectSlides) {
  RestUnderTheThumb();
  Place(-0.2, 0.01, 1.97 + 1e-4);
  Forward();
  EXPECT_EQ(audit_.RestStep(/*disturbed=*/true), 0.0);
  world_.data()->time += 0.3;
  EXPECT_NEAR(audit_.RestStep(/*disturbed=*/false), 0.3, 1e-12);
  audit_.EndRest(/*unrest_s=*/0.4);
  EXPECT_EQ(audit_.Finish({}, true, true).failed, "");
  ExpectFailsBeyond("unrest_s", 0.4, &AuditBounds::unrest_s);
  EXPECT_EQ(audit_.Finish({.unrest_s = 0.1}, true, false).failed, "");
}

// The hand moves with the arm and the object moves with the hand, so there is no creep.
TEST_F(AuditBound, CreepIsMeasuredInTheHand) {
  RestUnderTheThumb();
  world_.SetArm(Eigen::VectorXd::Constant(1, 0.1));
  Place(-0.2, 0.0, 2.0 - 0.01 - 0.02 + 1e-4 + 0.1);
  audit_.EndRest(0.0);
  EXPECT_NEAR(audit_.Finish({}, true, true).creep_m_s, 0.0, 1e-12);
}

TEST_F(AuditBound, EqualityError) {
  world_.data()->qpos[world_.model()->jnt_qposadr[1]] = 0.003;
  Forward();
  Step(true);
  world_.data()->qpos[world_.model()->jnt_qposadr[1]] = 0.0;
  Forward();
  Step(true);  // the maximum stays
  ExpectFailsBeyond("equality_share", 0.003 / base::Deg(2.0), &AuditBounds::equality_share);
  EXPECT_EQ(audit_.Finish({}, false, false).failed, "");  // nothing was held
}

// The cube penetrates the table by 3 mm, then the palm.
TEST_F(AuditBound, PenetrationElsewhere) {
  Place(0.0, 0.0, 0.02 - 0.003);
  Forward();
  Step(/*holding=*/false);
  Place(0.0, 0.0, 2.0 - 0.05 - 0.02 + 0.004);
  Forward();
  Step(/*holding=*/false);
  ExpectFailsBeyond("elsewhere_max_m", 0.003, &AuditBounds::elsewhere_max_m);
  for (int i = 0; i < 98; ++i) {
    Place(0.0, 0.0, 0.02 - (i < 5 ? 0.002 : 0.001));
    Forward();
    Step(/*holding=*/true);
  }
  ExpectFailsBeyond("elsewhere_p95_m", 0.002, &AuditBounds::elsewhere_p95_m);
}

// The object rises by 10 mm without a cause and moves at 1 m/s: m g h + m v^2 / 2.
TEST_F(AuditBound, EnergyGained) {
  Forward();
  audit_.BeginRest();
  Place(0.0, 0.0, 1.01);
  world_.data()->qvel[world_.model()->nv - 12] = 1.0;
  Forward();
  audit_.RestStep(false);
  Place(0.0, 0.0, 0.5);
  Forward();
  audit_.RestStep(false);  // the maximum stays
  const double gain_J = kMass_kg * (base::kGravity * 0.01 + 0.5);
  EXPECT_NEAR(audit_.Finish({}, true, true).energy_gain_J, gain_J, 1e-9);
  AuditBounds bounds;
  bounds.energy_gain_m = 1.001 * gain_J / (kMass_kg * base::kGravity);
  EXPECT_EQ(audit_.Finish(bounds, true, true).failed, "");
  bounds.energy_gain_m = 0.999 * gain_J / (kMass_kg * base::kGravity);
  EXPECT_THAT(audit_.Finish(bounds, true, true).failed, StartsWith("energy_gain_j "));
}

// A cube with half side a spins at 10 rad/s; its inertia is m (2 a)^2 / 6 about any axis.
TEST_F(AuditBound, EnergyOfASpin) {
  Forward();
  audit_.BeginRest();
  world_.data()->qvel[world_.model()->nv - 7] = 10.0;
  Forward();
  audit_.RestStep(false);
  const double inertia_kgm2 = kMass_kg * 0.04 * 0.04 / 6.0;
  EXPECT_NEAR(audit_.Finish({}, true, true).energy_gain_J, 0.5 * inertia_kgm2 * 100.0, 1e-9);
}

// 1000 N/m times 2 mm is 2 N of 5 N. At a large error the engine clamps the force, and this time is
// counted: three steps of 2 ms.
TEST_F(AuditBound, TimeOfADriveAtItsLimit) {
  world_.data()->ctrl[0] = 0.002;
  Forward();
  Step(false);
  EXPECT_EQ(audit_.Finish({}, true, true).drive_limit_s, 0.0);
  EXPECT_TRUE(audit_.JointsAtLimits().empty());
  world_.data()->ctrl[0] = 0.5;
  Forward();
  for (int i = 0; i < 3; ++i) Step(false);
  world_.data()->ctrl[0] = 0.0;
  Forward();
  Step(false);
  EXPECT_NEAR(audit_.Finish({}, true, true).drive_limit_s, 0.006, 1e-12);
  EXPECT_THAT(audit_.JointsAtLimits(), ::testing::ElementsAre("slide"));
  ExpectFailsBeyond("drive_limit_s", 0.006, &AuditBounds::drive_limit_s);
  EXPECT_EQ(audit_.Finish({.drive_limit_s = 0.001}, false, false).failed, "");  // nothing was held
}

// The limit is 5 N and the drive may give nine tenths of it; 2 N is less.
TEST_F(AuditBound, ADriveThatGivesWayIsNotAtItsLimit) {
  for (const double sent_m : {0.006, -0.006, 0.002}) {
    Eigen::VectorXd position = Eigen::VectorXd::Constant(1, sent_m);
    for (int i = 0; i < 4; ++i) {
      world_.data()->ctrl[0] = position[0];
      Forward();
      servo_.GiveWay(world_.data(), 0.9, position);
    }
    EXPECT_NEAR(position[0], std::clamp(sent_m, -0.0045, 0.0045), 1e-9);
    EXPECT_FALSE(servo_.AtLimit(world_.data(), 0));
  }
}

// Most models of arms limit the actuator, not the joint; the lower limit counts.
TEST(DriveLimit, IsThatOfTheActuatorOrOfTheJoint) {
  const std::string at_joint = R"(actuatorfrcrange="-5 5")", kp = R"(kp="1000")";
  for (const auto& [joint, actuator] :
       {std::pair("", R"(forcerange="-5 5")"), std::pair(R"(actuatorfrcrange="-5 5")", ""),
        std::pair(R"(actuatorfrcrange="-9 9")", R"(forcerange="-5 5")"),
        std::pair(R"(actuatorfrcrange="-5 5")", R"(forcerange="-9 9")")}) {
    std::string scene = kHandScene;
    scene.replace(scene.find(at_joint), at_joint.size(), joint);
    scene.replace(scene.find(kp), kp.size(), kp + " " + actuator);
    World world(samples::WriteFile("limited_hand.xml", scene), {}, {});
    const ArmServo servo(world.model());
    EXPECT_EQ(DriveLimit(world.model(), servo.joints()[0], servo.actuators()[0]), 5.0) << scene;
    world.data()->ctrl[0] = 0.5;
    mj_forward(world.model(), world.data());
    EXPECT_TRUE(servo.AtLimit(world.data(), 0)) << scene;
    Eigen::VectorXd position = Eigen::VectorXd::Constant(1, 0.006);
    world.data()->ctrl[0] = position[0];
    mj_forward(world.model(), world.data());
    servo.GiveWay(world.data(), 0.9, position);
    EXPECT_LT(position[0], 0.006) << scene;
  }
}

TEST_F(AuditBound, AJointAtItsRangesEndIsNamed) {
  world_.SetArm(Eigen::VectorXd::Constant(1, 0.99));
  world_.data()->ctrl[0] = 0.99;
  Forward();
  Step(false);
  EXPECT_TRUE(audit_.JointsAtLimits().empty());
  world_.SetArm(Eigen::VectorXd::Constant(1, 0.997));
  Forward();
  Step(false);
  EXPECT_THAT(audit_.JointsAtLimits(), ::testing::ElementsAre("slide"));
}

// The arm is at 0 and was commanded to 3 mm.
TEST_F(AuditBound, TrackingError) {
  commanded_m_ = 0.003;
  Step(false);
  commanded_m_ = 0.0;
  Step(false);                  // the maximum stays
  audit_.Step(false, nullptr);  // an obstacle may block the arm
  ExpectFailsBeyond("tracking_error_rad", 0.003, &AuditBounds::tracking_error_rad);
}

TEST_F(AuditBound, WhatThePadsFeel) {
  audit_.RecordGrip(250.0, 100.0);
  audit_.RecordGrip(120.0, 100.0);  // the maximum stays
  ExpectFailsBeyond("grip_share", 2.5, &AuditBounds::grip_share);
}

// A beam of 0.384 m between tips 0.38 m apart penetrates each by 2 mm. If it touches only one tip,
// there is no distance between contacts.
TEST_F(AuditBound, PenetrationAsAShareOfWhatIsHeld) {
  AuditRecorder audit(world_, hand_, servo_, 1);
  const auto rest_at = [&](double x) {
    world_.PlaceObject(1, base::MakePose(Eigen::Matrix3d::Identity(), {x, 0.0, 2.0}));
    Forward();
    audit.Step(true, nullptr);
    audit.BeginRest();
  };
  rest_at(0.003);  // out of one tip, 5 mm deep in the other
  EXPECT_EQ(audit.Finish({}, false, false).penetration_share, 0.0);
  rest_at(0.0);
  const double share = audit.Finish({}, false, false).penetration_share;
  EXPECT_NEAR(share, 0.005 / 0.382, 1e-4);  // a contact is in the middle of the overlap
  AuditBounds bounds;
  bounds.penetration_p95_m = bounds.penetration_max_m = 1.0;
  bounds.penetration_share = 0.999 * share;
  EXPECT_THAT(audit.Finish(bounds, true, true).failed, StartsWith("penetration_share "));
  bounds.penetration_share = 1.001 * share;
  EXPECT_EQ(audit.Finish(bounds, true, true).failed, "");
}

TEST_F(AuditBound, EngineWarnings) {
  world_.data()->qvel[world_.model()->nv - 12] = std::numeric_limits<double>::quiet_NaN();
  world_.Step();
  const Audit audit = audit_.Finish({}, false, false);
  EXPECT_GT(audit.warnings, 0);
  EXPECT_THAT(audit.failed, StartsWith("engine warnings"));
}

TEST_F(AuditBound, AFigureThatIsNoNumberIsOutOfBounds) {
  RestUnderTheThumb();
  Place(0.0, std::numeric_limits<double>::quiet_NaN(), 1.0);
  audit_.EndRest(0.0);
  EXPECT_THAT(audit_.Finish({}, true, true).failed, StartsWith("creep_m_s nan"));
}

}  // namespace
}  // namespace rangegrasp::sim::internal
