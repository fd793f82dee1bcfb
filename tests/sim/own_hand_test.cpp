// Hands that declare how they close, on the shipped arm: only friction holds the carried object.

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "base/units.h"
#include "hand_cell.h"
#include "robot/mjcf/hand.h"
#include "sim/execute.h"
#include "sim/grasp_program.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using testing_support::ExampleHand;
using testing_support::TempFolder;

struct OwnHandCase {
  const char* hand;
  const char* object;  ///< upright
  double height_m;     ///< height of the tool centre
  double felt = 0.9;   ///< minimum share of the commanded force
};

samples::HandMadeGrasp GraspOf(const OwnHandCase& setup) {
  samples::HandMadeGrasp grasp;
  grasp.point_W = {0, 0, setup.height_m};
  grasp.yaw_rad = base::kPi / 2;
  return grasp;
}

World OwnHandArrange(const TempFolder& folder, const OwnHandCase& setup) {
  const auto scene = testing_support::WriteHandCell(folder, ExampleHand(setup.hand));
  return samples::StandingAlone(scene, samples::RepositoryObject(setup.object));
}

class OwnHand : public ::testing::TestWithParam<OwnHandCase> {};

TEST_P(OwnHand, DeliversWithinTheBoundsOfTheAudit) {
  const TempFolder folder;
  World world = OwnHandArrange(folder, GetParam());
  const auto program = samples::MakeProgram(world, GraspOf(GetParam()));
  const ExecutionLog log = Execute(world, 0, program, {}, {}, base::Rng(1));
  EXPECT_TRUE(samples::Delivered(log));
  EXPECT_EQ(log.audit.failed, "");
  // The pads feel the commanded force: the drives' forces follow from the hand's own kinematics.
  // Fingertips that move on an arc and meet a round side obliquely lose a part to friction.
  EXPECT_GE(log.felt_force_N, GetParam().felt * log.grip_force_N);
  EXPECT_LE(log.felt_force_N, 1.1 * log.grip_force_N);
}

TEST_P(OwnHand, BesideTheObjectLiftsNothing) {
  const TempFolder folder;
  World world = OwnHandArrange(folder, GetParam());
  const auto program =
      samples::MakeProgram(world, samples::Beside(GraspOf(GetParam()), {-0.085, 0, 0}));
  const ExecutionLog log = Execute(world, 0, program, {}, {}, base::Rng(1));
  EXPECT_FALSE(log.held_after_lift);
  EXPECT_LT(log.lift_height_m, 0.01);
}

// The shipped hand's gear locks; a back-drivable drive has only its force.
TEST_P(OwnHand, NothingLocks) {
  const TempFolder folder;
  World world = OwnHandArrange(folder, GetParam());
  const mjModel* model = world.model();
  const std::vector<mjtNum> ranges(model->jnt_range, model->jnt_range + 2 * model->njnt);
  const auto program = samples::MakeProgram(world, GraspOf(GetParam()));
  ExecutionObserver observer;
  bool lifted = false;
  observer.on_moment = [&](const std::string& moment, World& w) {
    if (moment != "lifted") return;
    lifted = true;
    EXPECT_TRUE(std::equal(ranges.begin(), ranges.end(), w.model()->jnt_range));
  };
  Execute(world, 0, program, {}, {}, base::Rng(1), observer);
  EXPECT_TRUE(lifted);
}

// At zero, the jaws are closed.
TEST(ParallelJaw, StandsOpenFromTheStartAndStaysSo) {
  const TempFolder folder;
  World world(testing_support::WriteHandCell(folder, ExampleHand("parallel_jaw")), {}, {});
  const mjModel* model = world.model();
  const auto jaw_m = [&](const char* joint) {
    return world.data()->qpos[model->jnt_qposadr[mjcf::Find(model, mjOBJ_JOINT, joint)]];
  };
  EXPECT_NEAR(jaw_m("thumb_jaw"), 0.05, 1e-4);
  EXPECT_NEAR(jaw_m("finger_jaw"), 0.05, 1e-4);
  for (int i = 0; i < 500; ++i) world.Step();
  EXPECT_NEAR(jaw_m("thumb_jaw"), 0.05, 1e-3);
  EXPECT_NEAR(jaw_m("finger_jaw"), 0.05, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(
    Hands, OwnHand,
    ::testing::Values(OwnHandCase{"parallel_jaw", "dextrose", 0.10},
                      OwnHandCase{"parallel_jaw", "salt_cylinder", 0.09},
                      OwnHandCase{"three_fingers", "salt_cylinder", 0.09, 0.6}),
    [](const auto& tested) { return std::string(tested.param.hand) + "_" + tested.param.object; });

}  // namespace
}  // namespace rangegrasp::sim
