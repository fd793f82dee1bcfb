#include "clearing/clear.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "clearing/task/clearing_task.h"
#include "experiment/experiment.h"
#include "sim/resting_poses.h"
#include "trial/grasping_task.h"
#include "trial/options.h"

namespace rangegrasp::clearing {
namespace {

using trial::Outcome;

const trial::Cell& TestCell() {
  static const auto experiment = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {.set = {"physics.friction=middle"}});
  return trial::CellOf(*experiment.task);
}

// Objects at rest at the given places of the workspace [m].
sim::World Placed(const std::vector<std::string>& names,
                  const std::vector<Eigen::Vector2d>& places) {
  const auto& cell = TestCell();
  constexpr double kPutDown_m = 0.0005;
  std::vector<sim::ObjectModel> models;
  for (const auto& name : names) models.push_back(trial::ObjectModelOf(cell.options, name));
  sim::World world(cell.options.scene, models, cell.options.physics);
  world.SetArm(cell.robot.home);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto face = sim::StableRestingPoses(models[i], cell.options.min_tipping_rad)[0].faces[0];
    const Eigen::Vector3d place_W =
        cell.robot.X_WWorkspace * Eigen::Vector3d(places[i].x(), places[i].y(), 0.0);
    world.PlaceObject(static_cast<int>(i),
                      base::MakePose(face.R_WO.toRotationMatrix(),
                                     {place_W.x(), place_W.y(), face.height_m + kPutDown_m}));
  }
  EXPECT_TRUE(world.Settle());
  return world;
}
sim::World TwoObjects() {
  return Placed({"salt_cuboid", "sweets_cylinder"}, {{0.0, 0.10}, {0.0, -0.10}});
}

// The cell's detector with a change applied to its detections.
class Changed : public trial::Recorder, public trial::Detector {
 public:
  explicit Changed(std::function<void(grasp::Detection&)> change)
      : Recorder(TestCell()), change_(std::move(change)) {}
  const trial::Detector& detector() const override { return *this; }
  trial::Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                         const trial::Turn& turn) const override {
    auto detected = TestCell().detector->Detect(observation, rng, turn);
    change_(detected.detection);
    return detected;
  }

 private:
  std::function<void(grasp::Detection&)> change_;
};

Clearing Clear(sim::World& world, trial::Recorder* changed = nullptr,
               const ClearingOptions& options = {.max_grasps = 36}) {
  trial::Recorder none(TestCell());
  return ClearTable(TestCell(), options, world, /*seed=*/7, changed ? *changed : none);
}

TEST(ClearTable, TwoObjectsApartAreClearedWithTwoGrasps) {
  auto world = TwoObjects();
  const Clearing cleared = Clear(world);
  EXPECT_EQ(cleared.stop, Stop::kNothingPerceived);
  EXPECT_EQ(cleared.Grasps(), 2);
  EXPECT_EQ(cleared.Count(Fate::kDelivered), 2);
  EXPECT_EQ(cleared.scans, 3);  // the last one shows that the table is empty
  EXPECT_EQ(cleared.perceived, 0u);
  for (const auto& end : cleared.objects) {
    EXPECT_EQ(end.fate, Fate::kDelivered);
    EXPECT_EQ(end.grasps, 1);
    EXPECT_EQ(end.why, "");
  }
  for (int i = 0; i < world.objects(); ++i) EXPECT_TRUE(world.parked(i));
  EXPECT_EQ(ResultOf(cleared, "").outcome, kCleared);
}

TEST(ClearTable, AHandThatClosesOnNothingIsFeltAndTriesThreeTimes) {
  auto world = Placed({"salt_cuboid"}, {{0.0, 0.0}});
  // Half an opening above the object.
  Changed beside([](grasp::Detection& detection) {
    for (auto& g : detection.grasps) g.X_CH.translation().z() += 0.15;
  });
  const Clearing run = Clear(world, &beside);
  EXPECT_EQ(run.stop, Stop::kTriesUsedUp);
  EXPECT_EQ(run.Grasps(), 3);
  int tries = 0;
  for (const Step& step : run.steps) {
    if (!step.attempt.log) continue;
    EXPECT_EQ(step.try_number, ++tries);
    EXPECT_EQ(step.attempt.outcome, Outcome::kNotLifted);
    EXPECT_FALSE(step.felt);
    EXPECT_FALSE(step.attempt.log->aperture.feels_object_after_lift);
  }
  EXPECT_EQ(run.objects[0].fate, Fate::kLeft);
  EXPECT_EQ(run.objects[0].why, "tries_used_up");
  EXPECT_EQ(run.objects[0].grasps, 3);
  EXPECT_EQ(ResultOf(run, "").outcome, "tries_used_up");
}

TEST(ClearTable, AnObjectThatCannotBeTakenDoesNotKeepTheOthers) {
  auto world = TwoObjects();
  Changed blocked([](grasp::Detection& detection) {
    for (auto& g : detection.grasps) g.collides = g.X_CH.translation().y() > 0.0;
  });
  const Clearing run = Clear(world, &blocked);
  EXPECT_EQ(run.stop, Stop::kNothingGraspable);
  EXPECT_EQ(run.Grasps(), 1);
  EXPECT_EQ(run.objects[0].why, "no_grasp");
  EXPECT_EQ(run.objects[1].fate, Fate::kDelivered);
}

TEST(ClearTable, EndsWhereNothingIsGraspable) {
  auto world = TwoObjects();
  Changed blocked([](grasp::Detection& detection) {
    for (auto& g : detection.grasps) g.collides = true;
  });
  const Clearing run = Clear(world, &blocked);
  EXPECT_EQ(run.stop, Stop::kNothingGraspable);
  EXPECT_EQ(run.Grasps(), 0);
  EXPECT_EQ(run.scans, 3);  // two more than the first
  for (const auto& end : run.objects) EXPECT_EQ(end.why, "no_grasp");
}

TEST(ClearTable, EndsAtTheMostGrasps) {
  auto world = TwoObjects();
  const Clearing run = Clear(world, nullptr, {.max_grasps = 1});
  EXPECT_EQ(run.stop, Stop::kMaxGrasps);
  EXPECT_EQ(run.Grasps(), 1);
  EXPECT_EQ(run.Count(Fate::kDelivered), 1);
}

TEST(ClearTable, AnEmptyTableIsSeenToBeEmpty) {
  auto world = Placed({"salt_cuboid"}, {{0.0, 0.0}});
  world.ParkObject(0);
  const Clearing run = Clear(world);
  EXPECT_EQ(run.stop, Stop::kNothingPerceived);
  EXPECT_EQ(run.scans, 1);
}

TEST(ClearTable, WhatLiesOutsideTheWorkspaceIsLeftAndSaidSo) {
  auto world = Placed({"salt_cuboid", "spread"}, {{0.0, 0.0}, {0.05, 0.48}});
  const Clearing run = Clear(world);
  EXPECT_EQ(run.stop, Stop::kNothingPerceived);
  EXPECT_EQ(run.objects[0].fate, Fate::kDelivered);
  EXPECT_EQ(run.objects[1].fate, Fate::kLeft);
  EXPECT_EQ(run.objects[1].why, "out_of_workspace");
  // The program considers the table empty, but it is not cleared.
  EXPECT_EQ(ResultOf(run, "").outcome, "nothing_perceived");
}

TEST(ClearTable, TheSameSeedGivesTheSameBytes) {
  auto one = TwoObjects();
  auto two = TwoObjects();
  EXPECT_EQ(ResultOf(Clear(one), "").data, ResultOf(Clear(two), "").data);
}

TEST(ResultOf, NamesEachAttemptAndEachObject) {
  auto world = TwoObjects();
  const auto data = nlohmann::json::parse(ResultOf(Clear(world), "salt_cuboid").data);
  EXPECT_EQ(data["target"], "salt_cuboid");
  EXPECT_EQ(data["objects"], 2);
  EXPECT_EQ(data["delivered"], 2);
  EXPECT_EQ(data["left"], 0);
  ASSERT_EQ(data["attempts"].size(), 3u);
  for (int i = 0; i < 2; ++i) {
    const auto& attempt = data["attempts"][static_cast<std::size_t>(i)];
    EXPECT_EQ(attempt["outcome"], "delivered");
    EXPECT_EQ(attempt["felt"], true);
    EXPECT_EQ(attempt["try"], 1);
    EXPECT_EQ(attempt["taken_away"], nlohmann::json::array({attempt["object"]}));
    EXPECT_EQ(attempt["log"]["audit"]["failed"], "");
  }
  EXPECT_GT(data["simulated_s"].get<double>(), 5.0);
  EXPECT_GT(data["homing_s"].get<double>(), 0.5);
}

Samples Range(std::uint32_t first, std::uint32_t count) {
  Samples samples;
  for (std::uint32_t i = 0; i < count; ++i) samples.push_back({0, first + i});
  return samples;
}

base::Pose At(double x_m) { return base::MakePose(Eigen::Matrix3d::Identity(), {x_m, 0.0, 0.0}); }

TEST(SharedSamples, IsTheShareOfThoseThatEitherHas) {
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(0, 10)), 1.0);
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(5, 10)), 5.0 / 15.0);
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(10, 10)), 0.0);
  EXPECT_DOUBLE_EQ(SharedSamples({{0, 1}, {1, 2}}, {{1, 2}, {0, 2}}), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(SharedSamples({}, {}), 0.0);
}

TEST(TriedObjects, AnObjectIsPassedOverForGoodAfterItsTries) {
  TriedObjects tried(/*tries_per_object=*/2);
  EXPECT_TRUE(tried.TurnOf(Range(0, 100)));
  tried.Failed(Range(0, 100), At(0.0));
  EXPECT_EQ(tried.TriesAt(Range(0, 100)), 1);
  EXPECT_TRUE(tried.TurnOf(Range(0, 100)));
  tried.Failed(Range(3, 100), At(0.0));  // seen again with a little noise
  EXPECT_EQ(tried.StateOf(Range(0, 100)), Passed::kTriesUsedUp);
  tried.SceneChanged();
  EXPECT_FALSE(tried.TurnOf(Range(0, 100)));
  EXPECT_TRUE(tried.TurnOf(Range(80, 100)));  // its neighbor
}

TEST(TriedObjects, WhatHasFailedComesAfterTheOthers) {
  TriedObjects tried(/*tries_per_object=*/3);
  tried.Failed(Range(0, 100), At(0.0));
  EXPECT_EQ(tried.TurnOf(Range(0, 100)), 1);
  EXPECT_EQ(tried.TurnOf(Range(200, 100)), 0);
  tried.PassOver(Range(0, 100), Passed::kNoGrasp);
  EXPECT_EQ(tried.TurnOf(Range(0, 100)), std::nullopt);
}

TEST(TriedObjects, WhatHasNoGraspIsPassedOverUntilTheSceneChanges) {
  TriedObjects tried(/*tries_per_object=*/3);
  tried.PassOver(Range(0, 100), Passed::kNoGrasp);
  tried.PassOver(Range(200, 100), Passed::kNoPath);
  EXPECT_EQ(tried.StateOf(Range(0, 100)), Passed::kNoGrasp);
  EXPECT_EQ(tried.StateOf(Range(200, 100)), Passed::kNoPath);
  tried.SceneChanged();
  EXPECT_TRUE(tried.TurnOf(Range(0, 100)));
  EXPECT_TRUE(tried.TurnOf(Range(200, 100)));
}

TEST(TriedObjects, WhatIsSeenInThePlaceOfATakenObjectIsNew) {
  TriedObjects tried(/*tries_per_object=*/1);
  tried.Failed(Range(0, 100), At(0.0));
  tried.Taken(Range(0, 100));
  EXPECT_TRUE(tried.TurnOf(Range(0, 100)));
}

TEST(TriedObjects, GraspsLikeOneThatHasFailedComeLast) {
  TriedObjects tried(/*tries_per_object=*/3);
  tried.Failed(Range(0, 100), At(0.0));
  grasp::Detection detection;
  detection.objects.resize(1);
  detection.objects[0].samples = Range(0, 100);
  for (const double x_m : {0.0, 0.009, 0.030, 0.001, 0.020}) {
    detection.grasps.emplace_back().X_CH = At(x_m);
  }
  tried.PutFailedLast(detection);
  std::vector<double> order;
  for (const auto& g : detection.grasps) order.push_back(g.X_CH.translation().x());
  EXPECT_EQ(order, (std::vector<double>{0.030, 0.020, 0.0, 0.009, 0.001}));

  detection.objects[0].samples = Range(500, 100);  // no grasp at another object has failed
  std::swap(detection.grasps[0], detection.grasps[2]);
  tried.PutFailedLast(detection);
  EXPECT_EQ(detection.grasps[0].X_CH.translation().x(), 0.0);
}

}  // namespace
}  // namespace rangegrasp::clearing
