#include "grasp/mover.h"

#include <gtest/gtest.h>

#include "experiment/experiment.h"
#include "geometry/sample_meshes.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

// A single can and its detection.
class MoverTest : public testing::Test {
 protected:
  MoverTest()
      : experiment_(
            experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {})),
        cell_(CellOf(*experiment_.task)) {
    const TrialSpec spec{"salt_cylinder", 0, TrialSeed(11, "salt_cylinder", 0)};
    const auto arranged = ArrangeTrial(cell_, spec);
    base::Rng rng(1);
    detection_ =
        cell_.detector->Detect(Look(cell_, arranged->world, spec.seed).observation, rng).detection;
    // An obstacle above the can, where the hand must pass.
    in_the_way_ = geometry::samples::BoxMesh(Eigen::Vector3d::Constant(0.05),
                                             detection_.grasps.front().X_CH.translation());
  }
  grasp::Move Plan() const { return Plan(cell_.options); }
  grasp::Move Plan(const grasp::MoverOptions& options) const {
    base::Rng rng(1);
    return grasp::PlanMove(detection_, cell_.robot.home, options,
                           cell_.options.grasp.friction_cone_rad, cell_.robot, rng);
  }
  // Rates whether a grasp holds, by its probability or by its contact angle.
  void Rate(bool holds, bool learned, grasp::DetectedGrasp& grasp) const {
    grasp.probability = std::nullopt;
    if (learned) grasp.probability = holds ? 0.9 : 0.1;
    grasp.contact_angle_rad =
        cell_.options.grasp.friction_cone_rad + (holds == learned ? 0.1 : -0.1);
  }

  experiment::Experiment experiment_;
  const Cell& cell_;
  grasp::Detection detection_;
  geometry::TriangleMesh in_the_way_;
};

TEST_F(MoverTest, SeesWhereItGoesWhereItCan) {
  const grasp::Move move = Plan();
  EXPECT_TRUE(move.plan);
  EXPECT_FALSE(move.blind);
}

TEST_F(MoverTest, PassesUnseenSpaceAsTheLastResort) {
  detection_.obstacles.unseen_C = {in_the_way_};
  const grasp::Move move = Plan();
  EXPECT_TRUE(move.plan);
  EXPECT_TRUE(move.blind);
}

TEST_F(MoverTest, NeverPassesWhatWasMeasured) {
  detection_.obstacles.measured_C = {in_the_way_};
  const grasp::Move move = Plan();
  EXPECT_FALSE(move.plan);
  EXPECT_FALSE(move.blind);
  EXPECT_NE(move.failures, "");
}

// The can's grasps, best first, twice: first rated as not holding, then as holding.
TEST_F(MoverTest, PassesUnseenSpaceForAGraspThatHoldsBeforeItTakesOneThatDoesNot) {
  const std::size_t count = detection_.grasps.size();
  const std::vector<grasp::DetectedGrasp> sound = detection_.grasps;
  detection_.grasps.insert(detection_.grasps.end(), sound.begin(), sound.end());
  const auto obstacles = detection_.obstacles;
  for (const bool learned : {false, true}) {
    for (std::size_t i = 0; i < 2 * count; ++i) Rate(i >= count, learned, detection_.grasps[i]);
    for (const bool unseen : {false, true}) {
      detection_.obstacles = obstacles;
      if (unseen) detection_.obstacles.unseen_C = {in_the_way_};
      const grasp::Move move = Plan();
      ASSERT_TRUE(move.plan);
      EXPECT_GE(move.grasp, count) << learned;
      EXPECT_EQ(move.blind, unseen);
    }
  }
}

// As published: grasps are tried in order, and no motion passes through unseen space.
TEST_F(MoverTest, WithoutItsAdditionsTakesTheFirstGraspAndKeepsClearOfUnseenSpace) {
  for (auto& grasp : detection_.grasps) {
    Rate(&grasp != &detection_.grasps.front(), /*learned=*/false, grasp);
  }
  grasp::MoverOptions options = cell_.options;
  base::SwitchAll<grasp::MoverAdditions>(false, options);
  EXPECT_EQ(Plan(options).grasp, 0u);
  EXPECT_NE(Plan().grasp, 0u);
  detection_.obstacles.unseen_C = {in_the_way_};
  EXPECT_FALSE(Plan(options).plan);
}

}  // namespace
}  // namespace rangegrasp::trial
