#include "sim/execute.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "base/file.h"
#include "base/units.h"
#include "sim/grasp_program.h"
#include "sim/resting_poses.h"
#include "sim/scene_files.h"
#include "temp_folder.h"

namespace rangegrasp::sim {
namespace {

using samples::Delivered;
using samples::HandMadeGrasp;

struct Case {
  const char* object;  ///< upright
  HandMadeGrasp grasp;
  double first_grip_N = 20.0;
};

HandMadeGrasp Grasp(const Eigen::Vector3d& point_W, double pitch_deg) {
  HandMadeGrasp grasp;
  grasp.point_W = point_W;
  grasp.yaw_rad = base::kPi / 2;  // closes across the arm's reach
  grasp.pitch_rad = base::Deg(pitch_deg);
  return grasp;
}

const Case kBox{"dextrose", Grasp({0, 0, 0.100}, 10)};
const Case kCylinder{"salt_cylinder", Grasp({0, 0, 0.085}, 10)};
// With 20 to 50 N, or with 100 N, the cup creeps around its rim at 0.12 to 0.16 mm/s.
const Case kMugRim{"coffee_cup", Grasp({0, 0.039, 0.083}, 0), 70.0};

World Arrange(const Case& setup, const PhysicsOptions& physics = {}) {
  return samples::StandingAlone(samples::Tabletop(), samples::RepositoryObject(setup.object),
                                physics);
}

// A case's world, and the program of its grasp, or of one with an offset.
struct Prepared {
  explicit Prepared(const Case& setup, const PhysicsOptions& physics = {},
                    const Eigen::Vector3d& aside_W = Eigen::Vector3d::Zero())
      : world(Arrange(setup, physics)),
        program(samples::MakeProgram(world, samples::Beside(setup.grasp, aside_W))) {}

  ExecutionLog Run(const HandControlOptions& hand = {}, const ExecutionObserver& observer = {}) {
    return Execute(world, 0, program, hand, {}, base::Rng(1), observer);
  }

  World world;
  GraspProgram program;
};

ExecutionLog Try(const Case& setup, const PhysicsOptions& physics = {},
                 const HandControlOptions& hand = {}) {
  return Prepared(setup, physics).Run(hand);
}

// 20 mm of air between the hand and the object's side.
const Eigen::Vector3d kToTheSide_W(-(0.045 + 0.020 + 0.02), 0, 0);

class GoodGrasp : public ::testing::TestWithParam<const Case*> {};

TEST_P(GoodGrasp, DeliversWithinTheBoundsOfTheAudit) {
  HandControlOptions hand;
  hand.initial_force_N = GetParam()->first_grip_N;
  const ExecutionLog log = Try(*GetParam(), {}, hand);
  EXPECT_TRUE(Delivered(log));
  EXPECT_EQ(log.audit.failed, "");
  EXPECT_EQ(log.audit.warnings, 0);
  EXPECT_GT(log.audit.tracking_error_rad, 0.0);
  EXPECT_GT(log.tracking_error_m, 0.0);
  EXPECT_GT(log.audit.penetration_max_m, 0.0);  // it was measured
  EXPECT_GE(log.grip_force_N, GetParam()->first_grip_N);
  // The pads' sensors work; the fingers' other segments carry part of the 20 N.
  EXPECT_GT(log.felt_force_N, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Objects, GoodGrasp, ::testing::Values(&kBox, &kCylinder, &kMugRim),
                         [](const auto& tested) { return std::string(tested.param->object); });

// Self-test of the scoring: grasps that must fail do fail.
TEST(BadGrasp, BesideTheObjectLiftsNothing) {
  for (const Case* good : {&kBox, &kCylinder}) {
    const ExecutionLog log = Prepared(*good, {}, kToTheSide_W).Run();
    EXPECT_FALSE(log.held_after_lift) << good->object;
    EXPECT_FALSE(Delivered(log)) << good->object;
    EXPECT_LT(log.lift_height_m, 0.01) << good->object;
  }
}

TEST(BadGrasp, AHandThatNeverClosesLiftsNothing) {
  HandControlOptions open;
  open.closing_speed_rad_s = 0.0;
  open.initial_force_N = open.max_force_N = open.min_force_N = 0.0;
  for (const Case* setup : {&kBox, &kCylinder, &kMugRim}) {
    const ExecutionLog log = Try(*setup, {}, open);
    EXPECT_FALSE(log.held_after_lift) << setup->object;
    EXPECT_LT(log.lift_height_m, 0.01) << setup->object;
  }
}

// A hand that loses its object must not snap shut. A motor with 100 N and no speed limit caused an
// impact that the gear locked in, with up to 6 kN between the fingers.
TEST(ShippedHand, TheStrongestGripShutsNoFasterThanTheMotorTurns) {
  World world = Arrange(kBox);
  const mjModel* model = world.model();
  const int motor = mj_name2id(model, mjOBJ_ACTUATOR, "arm/hand/motor");
  const int drive = mj_name2id(model, mjOBJ_TENDON, "arm/hand/drive");
  ASSERT_GE(motor, 0);
  ASSERT_GE(drive, 0);
  const double full_Nm = model->actuator_ctrlrange[2 * motor + 1];
  double fastest_rad_s = 0.0;
  for (int step = 0; step < 200; ++step) {
    world.data()->ctrl[motor] = step < 100 ? -full_Nm : full_Nm;
    world.Step();
    fastest_rad_s = std::max(fastest_rad_s, world.data()->ten_velocity[drive]);
  }
  EXPECT_GT(fastest_rad_s, 1.5);
  // Half of the damping is explicit, so the first step overshoots.
  EXPECT_LT(fastest_rad_s, 1.5 * HandControlOptions().closing_speed_rad_s);
}

TEST(Approach, TheHandClosesWhereItsFingertipsMeetSomethingEarly) {
  Prepared box(kBox, {}, {0, 0.05, 0});  // one side of the hand lands on the box's top
  const Eigen::Vector3d before_W = box.world.ObjectPose(0).translation();
  std::vector<std::string> moments;
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  ExecutionObserver observer;
  observer.on_moment = [&](const std::string& moment, World& world) {
    moments.push_back(moment);
    if (moment == "pregrasp") moved_m = world.ObjectPose(0).translation() - before_W;
  };
  const ExecutionLog log = box.Run({}, observer);
  EXPECT_EQ(log.stopped_by_contact.front(), "approach");
  EXPECT_LT(moved_m.norm(), 0.002);
  ASSERT_GE(moments.size(), 2u);
  EXPECT_EQ(moments[0], "pregrasp");
  EXPECT_EQ(moments[1], "closed");
}

ExecutionLog HandOver(const UserOptions& user) {
  Prepared tube(Case{"demo_tube", Grasp({0, 0, 0.120}, 10)});
  tube.program.user = user;
  return tube.Run();
}

TEST(HandOver, APullIsFeltAndThePersonHasTheObject) {
  const ExecutionLog log = HandOver({});
  ASSERT_TRUE(log.hand_over);
  EXPECT_FALSE(log.hand_over->early);
  EXPECT_TRUE(log.hand_over->felt);
  EXPECT_TRUE(log.hand_over->taken);
  EXPECT_GT(log.hand_over->felt_N, 1.0);
  EXPECT_LE(log.hand_over->felt_N, 15.0);
  EXPECT_EQ(log.audit.failed, "");
}

// The arm feels a pull in any direction, whether it is stretched along the pull or not.
TEST(HandOver, IsFeltFromEverySide) {
  for (const Eigen::Vector3d& along_H :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 1, 0),
        Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)}) {
    UserOptions user;
    user.direction_H = along_H;
    const ExecutionLog log = HandOver(user);
    ASSERT_TRUE(log.hand_over);
    EXPECT_TRUE(log.hand_over->felt) << along_H.transpose();
    EXPECT_FALSE(log.hand_over->early);
    // After subtracting the tube's weight of 1.5 N, the felt force is the pull: 5 N.
    EXPECT_NEAR(log.hand_over->felt_N, 5.0, 2.5) << along_H.transpose();
  }
}

// The person's spring and damper act once per step; on light objects they have to be weaker.
TEST(HandOver, ALightObjectIsTakenAsWell) {
  const testing_support::TempFolder folder;
  const std::filesystem::path box = samples::RepositoryObject("dextrose").mjcf;
  std::filesystem::copy(box.parent_path(), folder / "box");
  std::string xml = base::ReadFile(box);
  const auto begin = xml.find("<inertial");
  xml.replace(begin, xml.find("/>", begin) - begin,
              R"(<inertial mass="0.05" pos="0 0 0" fullinertia="3e-05 4e-05 2.5e-05 0 0 0")");
  base::WriteFile(folder / "box/dextrose.xml", xml);
  World world =
      samples::StandingAlone(samples::Tabletop(), {"dextrose", folder / "box/dextrose.xml"});
  GraspProgram program = samples::MakeProgram(world, kBox.grasp);
  program.user = UserOptions{};
  const ExecutionLog log = Execute(world, 0, program, {}, {}, base::Rng(1), {});
  EXPECT_EQ(log.audit.failed, "");
  ASSERT_TRUE(log.hand_over);
  EXPECT_TRUE(log.hand_over->taken);
}

TEST(HandOver, WithoutAPullTheHandHolds) {
  UserOptions still;
  still.force_N = 0.2;
  const ExecutionLog log = HandOver(still);
  ASSERT_TRUE(log.hand_over);
  EXPECT_FALSE(log.hand_over->early);
  EXPECT_FALSE(log.hand_over->felt);
  EXPECT_FALSE(log.hand_over->taken);
  EXPECT_TRUE(log.touched_by_hand);
}

const PhysicsOptions kSlippery{.glove_friction = 0.02};

// With a friction of 0.02, even 100 N cannot carry these: 2 * 0.02 * 100 N = 4 N, but the box
// weighs 4.1 N and the tube 5.2 N.
TEST(BadGrasp, ASlipperyGloveHoldsNothing) {
  for (const Case* setup : {&kBox, &kCylinder}) {
    const ExecutionLog log = Try(*setup, kSlippery);
    EXPECT_FALSE(Delivered(log)) << setup->object;
    EXPECT_FALSE(log.held_after_carry) << setup->object;
  }
}

// The log of an object that was never lifted has the data needed to understand the failure.
TEST(BadGrasp, ALostObjectLeavesForceAndSlip) {
  const ExecutionLog log = Try(kCylinder, kSlippery);
  ASSERT_FALSE(log.held_after_lift);
  EXPECT_GT(log.grip_force_N, 20.0);
  EXPECT_GT(log.slips_heard, 0);
  EXPECT_GT(log.slip_in_hand_m, 0.005);
}

// Below its threshold the sensor detects nothing, and the grip force stays at its first value.
TEST(SlipControl, WhatIsNotHeardRaisesNoForce) {
  HandControlOptions deaf;
  deaf.slip_threshold_m_s = 1e9;
  const ExecutionLog log = Try(kCylinder, kSlippery, deaf);
  EXPECT_EQ(log.slips_heard, 0);
  EXPECT_DOUBLE_EQ(log.grip_force_N, 20.0);
}

// A sliding object follows Coulomb friction; the hand responds with more force.
TEST(SlipControl, RaisesTheForceUntilTheObjectStays) {
  HandControlOptions gentle;
  gentle.initial_force_N = 12.0;
  const Case bottle{"cleaner", Grasp({0, 0, 0.215}, 10)};
  PhysicsOptions smooth;
  smooth.glove_friction = 0.3;  // 12 N hold 7.2 N of 8
  const ExecutionLog with = Try(bottle, smooth, gentle);
  gentle.slip_control = false;
  const ExecutionLog without = Try(bottle, smooth, gentle);
  EXPECT_TRUE(Delivered(with));
  EXPECT_GT(with.grip_force_N, 12.0);
  EXPECT_LT(with.slip_in_hand_m, without.slip_in_hand_m);
}

// Records the commanded grip forces of every step by stage.
ExecutionObserver WatchForce(std::map<std::string, std::vector<double>>& forces_N) {
  ExecutionObserver observer;
  observer.frame_period_s = 0.002;
  observer.on_moment = [](const std::string&, World&) {};
  observer.on_state = [&](const ExecutionState& now) {
    forces_N[now.stage].push_back(now.force_N);
  };
  return observer;
}

TEST(SlipControl, NeverCommandsMoreThanTheStrongestGrip) {
  HandControlOptions hand;
  hand.max_force_N = 65.0;  // not a whole number of force steps away
  std::map<std::string, std::vector<double>> forces_N;
  Prepared(kCylinder, kSlippery).Run(hand, WatchForce(forces_N));
  ASSERT_FALSE(forces_N["lift"].empty());
  EXPECT_DOUBLE_EQ(std::ranges::max(forces_N["lift"]), 65.0);
}

// The bottle slips in a grip of 12 N. The force is raised and stays high while the bottle hangs;
// back on the table, the bottle's weight no longer pulls.
TEST(SlipControl, ReturnsToTheFirstGripWhenTheObjectIsPutDown) {
  const Case bottle{"cleaner", Grasp({0, 0, 0.215}, 10)};
  PhysicsOptions smooth;
  smooth.glove_friction = 0.3;
  HandControlOptions gentle;
  gentle.initial_force_N = 12.0;
  const double slip_m = Try(bottle, smooth, gentle).slip_in_hand_m;
  Prepared prepared(bottle, smooth);
  GraspProgram& program = prepared.program;
  program.carry = {};
  auto& way = program.lower.positions;
  way.assign(program.lift.positions.rbegin(), program.lift.positions.rend());
  samples::TestArm arm(prepared.world);
  const auto height_m = [&](const Eigen::VectorXd& q) { return arm.HandPose(q).translation().z(); };
  // The bottle then stands on the table, pressed down by 0.5 mm.
  const double end_m = height_m(way.back()) + slip_m - 0.0005;
  while (height_m(way.back()) < end_m) way.pop_back();
  way.insert(way.end(), static_cast<std::size_t>(0.5 / program.lower.period_s), way.back());
  std::map<std::string, std::vector<double>> forces_N;
  const ExecutionLog log = prepared.Run(gentle, WatchForce(forces_N));
  EXPECT_TRUE(log.held_after_carry);
  EXPECT_GT(log.grip_force_N, 12.0);
  const std::vector<double>& put_down_N = forces_N["deliver"];
  ASSERT_GT(put_down_N.size(), 1000u);
  EXPECT_DOUBLE_EQ(put_down_N.front(), log.grip_force_N);
  // The last states are with the open hand, whose force is 0.
  const auto open = std::ranges::find(put_down_N, 0.0);
  ASSERT_NE(open, put_down_N.end());
  EXPECT_DOUBLE_EQ(*(open - 1), 12.0);
}

// qpos, qvel and the log after a complete trial, as bytes.
std::string Bytes() {
  Prepared box(kBox);
  const ExecutionLog log = box.Run();
  const mjModel* model = box.world.model();
  const mjData* data = box.world.data();
  std::string bytes(reinterpret_cast<const char*>(data->qpos), sizeof(mjtNum) * model->nq);
  bytes.append(reinterpret_cast<const char*>(data->qvel), sizeof(mjtNum) * model->nv);
  for (const double value :
       {log.lift_height_m, log.final_distance_m, log.slip_in_hand_m, log.audit.penetration_max_m,
        log.audit.creep_m_s, log.audit.energy_gain_J, log.simulated_s}) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  return bytes;
}

TEST(Execute, RepeatsItselfToTheByteInOneProcessAndAcross) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::string bytes = Bytes();
    const auto written = ::write(ends[1], bytes.data(), bytes.size());
    ::_exit(written == static_cast<ssize_t>(bytes.size()) ? 0 : 1);
  }
  ::close(ends[1]);
  const std::string first = Bytes();
  const std::string second = Bytes();
  std::string other(first.size() + 1, '\0');
  std::size_t got = 0;
  for (ssize_t n;
       got < other.size() && (n = ::read(ends[0], other.data() + got, other.size() - got)) > 0;) {
    got += static_cast<std::size_t>(n);
  }
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  other.resize(got);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(first == second);
  EXPECT_TRUE(first == other);
}

// A program without ground truth uses this: the joints of a hand that has closed on an object stop
// earlier than those of an empty hand.
TEST(Aperture, TellsAHeldObjectFromNothing) {
  for (const Case* setup : {&kBox, &kCylinder, &kMugRim}) {
    Prepared good(*setup);
    good.program.ends_by = EndsBy::kAperture;
    const ExecutionLog log = good.Run();
    EXPECT_TRUE(log.aperture.feels_object_after_lift) << setup->object;
    EXPECT_TRUE(log.aperture.feels_object_after_carry) << setup->object;
    EXPECT_TRUE(Delivered(log)) << setup->object;
  }
  Prepared beside(kBox, {}, kToTheSide_W);
  beside.program.ends_by = EndsBy::kAperture;
  const ExecutionLog log = beside.Run();
  EXPECT_FALSE(log.aperture.feels_object_after_lift);
  EXPECT_FALSE(log.aperture.feels_object_after_carry);
  EXPECT_LT(log.lift_height_m, 0.01);
}

TEST(Aperture, AnEmptyHandIsLeftOpenForTheNextGrasp) {
  Prepared box(kBox, {}, kToTheSide_W);
  const base::Pose before = box.world.ObjectPose(0);
  const GraspProgram full = samples::MakeProgram(box.world, kBox.grasp);
  box.program.ends_by = EndsBy::kAperture;
  box.Run();
  box.world.SetArm(full.reach.positions.front());
  ASSERT_LT((box.world.ObjectPose(0).translation() - before.translation()).norm(), 0.001);
  box.program = full;
  EXPECT_TRUE(Delivered(box.Run()));
}

// The hand carries another object than the intended one, and the log describes the held object.
TEST(Aperture, TheLogIsOfWhatTheHandHolds) {
  const ObjectModel box = samples::RepositoryObject("dextrose");
  const ObjectModel other = samples::RepositoryObject("salt_cylinder");
  World world(samples::Tabletop(), {box, other}, {});
  for (const int object : {0, 1}) {
    const auto poses = StableRestingPoses(object == 0 ? box : other, 0.0);
    const RestingFace face = *FaceAtRest(poses, Eigen::Matrix3d::Identity())->face;
    world.PlaceObject(object,
                      base::MakePose(face.R_WO.toRotationMatrix(),
                                     {0, object == 0 ? 0.0 : 0.15, face.height_m + 0.0002}));
  }
  ASSERT_TRUE(world.Settle());
  GraspProgram program = samples::MakeProgram(world, kBox.grasp);
  program.ends_by = EndsBy::kAperture;
  const ExecutionLog log = Execute(world, /*target=*/1, program, {}, {}, base::Rng(1));
  EXPECT_TRUE(log.aperture.feels_object_after_carry);
  EXPECT_EQ(log.target, 0);
  EXPECT_TRUE(Delivered(log));
  EXPECT_EQ(log.audit.failed, "");
  const Eigen::Vector3d place_W = world.SitePose("delivery").translation();
  EXPECT_LT((world.ObjectCenterOfMass(0) - place_W).head<2>().norm(), 0.15);
}

// Extends the motion: the shoulder turns by another 17 deg in one second, which moves the hand
// 0.2 m down.
base::JointTrajectory AndDown(base::JointTrajectory motion) {
  for (double t = 0.0; t < 1.0; t += motion.period_s) {
    Eigen::VectorXd q = motion.positions.back();
    q[1] += 0.3 * motion.period_s;
    motion.positions.push_back(q);
  }
  return motion;
}

// The table blocks a motion that should be free. A robot's drives stop there: the grasp has failed,
// but the physics is valid.
TEST(Blocked, AMotionThatMeetsSomethingEndsTheGrasp) {
  for (const char* motion : {"reach", "lift"}) {
    for (const EndsBy ends_by : {EndsBy::kTruth, EndsBy::kAperture}) {
      Prepared box(kBox);
      box.program.ends_by = ends_by;
      base::JointTrajectory& blocked =
          motion == std::string("reach") ? box.program.reach : box.program.lift;
      if (motion == std::string("reach")) {
        const auto& approach = box.program.approach.positions;
        blocked.positions.insert(blocked.positions.end(), approach.begin(), approach.end());
      } else {
        blocked.positions.resize(1);
      }
      blocked = AndDown(blocked);
      const ExecutionLog log = box.Run();
      EXPECT_EQ(log.stopped_by_contact, std::vector<std::string>{motion});
      EXPECT_FALSE(log.held_after_lift) << motion;
      EXPECT_FALSE(Delivered(log)) << motion;
      EXPECT_EQ(log.audit.failed, "") << motion;
      EXPECT_LT(log.audit.tracking_error_rad, AuditBounds().tracking_error_rad) << motion;
    }
  }
}

// A strongly damped box, 20 mm off the hand's center, does not move to the hand. The arm gives way
// instead and has only a small position error when the hand has closed.
TEST(Blocked, TheArmGivesWayToAHandThatCloses) {
  Prepared box(kBox, {}, {0, 0.02, 0});
  const int dof = box.world.model()->body_dofadr[box.world.object_body(0)];
  std::fill_n(box.world.model()->dof_damping + dof, 6, 1e5);
  double lag_rad = -1.0;
  ExecutionObserver observer;
  observer.on_moment = [&](const std::string& moment, World& now) {
    if (moment != "closed") return;
    const Eigen::VectorXd sent =
        Eigen::Map<const Eigen::VectorXd>(now.data()->ctrl, now.ArmPositions().size());
    lag_rad = (sent - now.ArmPositions()).cwiseAbs().maxCoeff();
  };
  const ExecutionLog log = box.Run({}, observer);
  EXPECT_GE(lag_rad, 0.0);
  EXPECT_LT(lag_rad, 0.0045);  // 4 mrad plus the motion of one step
  EXPECT_LT(log.audit.drive_limit_s, AuditBounds().drive_limit_s);
}

TEST(Execute, TellsOfItsMoments) {
  std::map<std::string, int> seen;
  ExecutionObserver observer;
  observer.frame_period_s = 0.1;
  observer.on_moment = [&](const std::string& moment, World&) { ++seen[moment]; };
  const ExecutionLog log = Prepared(kBox).Run({}, observer);
  for (const char* moment : {"pregrasp", "closed", "lifted", "delivered", "end"})
    EXPECT_EQ(seen[moment], 1) << moment;
  EXPECT_NEAR(seen["frame"], log.simulated_s / 0.1, 2.0);
  // Each joint of the arm moved, and none stayed behind.
  ASSERT_EQ(log.lags_rad.size(), 7);
  EXPECT_GT(log.lags_rad.minCoeff(), 0.0);
  EXPECT_LT(log.lags_rad.maxCoeff(), 0.0045);
}

TEST(Execute, AParkedTargetIsACallersMistake) {
  World world(samples::Tabletop(), {samples::RepositoryObject("dextrose")}, {});
  EXPECT_THROW(Execute(world, 0, {}, {}, {}, base::Rng(1)), std::invalid_argument);
  EXPECT_THROW(Execute(world, 1, {}, {}, {}, base::Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::sim
