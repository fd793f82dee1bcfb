#include "parts/handle/handle_grasps.h"

#include <gtest/gtest.h>

#include "experiment/experiment.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

perception::PerceivedObject Add(const Eigen::Vector3d& from, int count, perception::Scene& scene) {
  perception::PerceivedObject object;
  for (int i = 0; i < count; ++i) {
    object.points.push_back(static_cast<std::uint32_t>(scene.cloud.points.size()));
    scene.cloud.points.emplace_back(from + 0.001 * i * Eigen::Vector3d::UnitZ());
  }
  return object;
}

TEST(JoinCutOffHandle, TakesWhatIsSmallAndNear) {
  perception::Scene scene;
  scene.objects.push_back(Add({0.0, 0.0, 0.0}, 80, scene));
  scene.objects.push_back(Add({0.2, 0.0, 0.0}, 10, scene));    // far
  scene.objects.push_back(Add({0.0, 0.02, 0.02}, 10, scene));  // the handle
  scene.objects.push_back(Add({0.0, -0.01, 0.0}, 40, scene));  // large
  parts::JoinCutOffHandle(scene);
  ASSERT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.objects[0].points.size(), 90u);
  EXPECT_EQ(scene.objects[1].points.front(), 80u);
  EXPECT_EQ(scene.objects[2].points.size(), 40u);
}

Attempt TryByHandle(int index) {
  const auto experiment = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
      {.set = {"objects=[coffee_cup]", "as_drawn=true", "grasp.take=handle"}});
  Attempt attempt;
  RunTrial(CellOf(*experiment.task), {"coffee_cup", index, TrialSeed(1001, "coffee_cup", index)},
           nullptr, {}, &attempt);
  return attempt;
}

// Of five cups with a visible handle, two are delivered. Three rotate in the hand by more than 0.1
// deg/s at rest, which the audit counts as creep.
TEST(TakeByHandle, ACupIsTakenByIt) {
  const Attempt attempt = TryByHandle(5);
  EXPECT_EQ(attempt.outcome, Outcome::kDelivered);
  ASSERT_TRUE(attempt.Grasp());
  EXPECT_EQ(attempt.Grasp()->name, "handle");
  EXPECT_LT(attempt.Grasp()->width_m, 0.013);  // the bar is 9.4 mm thick, the body 82 mm
}

TEST(TakeByHandle, IsRefusedWithAReasonWhereItIsOutOfSight) {
  const Attempt attempt = TryByHandle(1);
  EXPECT_EQ(attempt.outcome, Outcome::kNoGrasp);
  EXPECT_EQ(attempt.detail, "no handle: the visible surface of the object is a single part");
}

}  // namespace
}  // namespace rangegrasp::trial
