#include "recognition/task/bring_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "error_of.h"
#include "experiment/experiment.h"
#include "trial/trial.h"

namespace rangegrasp::bring {
namespace {

experiment::Experiment Open(std::vector<std::string> set,
                            const std::string& wanted = "coffee_cup") {
  set.emplace_back("runs_per_object=1");
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/bring.yaml",
                                    {.set = set, .seed = 1001, .groups = {wanted}});
}

nlohmann::json DataOf(const experiment::Result& result) {
  return nlohmann::json::parse(result.data);
}

TEST(BringTask, BringsTheCupAndSaysSo) {
  const auto experiment = Open({"arrangement=single"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "handed_over") << result.detail;
  const auto data = DataOf(result);
  EXPECT_EQ(data["words"].front(), "I am to bring the Coffee Cup.");
  EXPECT_EQ(data["words"].back(), "Here you are: the Coffee Cup.");
  EXPECT_TRUE(data["attempts"].back()["at_wanted"]);
  EXPECT_EQ(experiment.task->Run(experiment.cases[0]).data, result.data) << "the same bytes";
}

// A hand that stays 50 mm above the table can grasp a prism of 52 mm only by chance.
TEST(BringTask, GivesUpAfterThreeAttemptsInVainAtTheSameTable) {
  const auto experiment =
      Open({"arrangement=single", "grasp.table_clearance_mm=50"}, "sweets_prism");
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "no_grasp");
  const auto data = DataOf(result);
  int in_vain = 0;
  for (const auto& attempt : data["attempts"]) {
    in_vain = attempt["log"].empty() ? in_vain + 1 : 0;
  }
  EXPECT_EQ(in_vain, 3) << result.data;
  EXPECT_EQ(data["words"].back(), "I see the Sweets (prism), and cannot get at it.");
}

// In a heap another object is dropped last, on top.
TEST(BringTask, TheTargetOfItsSceneIsTheWantedObject) {
  const std::vector<std::string> heap = {"arrangement=pile",
                                         "objects=[coffee_cup, dextrose, salt_cuboid]"};
  const auto scene_of = [](const experiment::Experiment& e) {
    trial::Redraws redraws;
    return dynamic_cast<const trial::SceneTask&>(*e.task).Arrange(e.cases[0], redraws);
  };
  const auto present = scene_of(Open(heap));
  ASSERT_TRUE(present);
  EXPECT_EQ(present->world.object_name(present->target), "coffee_cup");
  EXPECT_NE(present->target, 0);
  auto without = heap;
  without.emplace_back("bring.absent=true");
  const auto absent = scene_of(Open(without));
  ASSERT_TRUE(absent);
  EXPECT_TRUE(absent->world.parked(present->target));
  EXPECT_FALSE(absent->world.parked(absent->target));
}

// The noise of a scan is larger than 0.17 of a tolerance of 0.5 mm.
TEST(BringTask, ATighterToleranceLeavesTheWantedObjectUnknown) {
  const auto seen = [](const std::string& tolerance_mm) {
    const auto experiment = Open({"arrangement=single", "objects=[coffee_cup]", "bring.max_looks=1",
                                  "recognition.tolerance_mm=" + tolerance_mm});
    return DataOf(experiment.task->Run(experiment.cases[0]))["words"][1];
  };
  EXPECT_EQ(seen("3"), "I look, and see the Coffee Cup.");
  EXPECT_EQ(seen("0.5"), "I look, and see a thing that I do not know.");
}

TEST(BringTask, ASceneWithoutAWristScannerNeedsOneOnlyForASecondLook) {
  const auto run = [](std::vector<std::string> set) {
    set.insert(set.end(), {"arrangement=single", "scene=../scenes/tabletop.xml"});
    const auto experiment = Open(set);
    return experiment.task->Run(experiment.cases[0]).outcome;
  };
  EXPECT_THAT(testing_support::ErrorOf([&] { run({}); }), testing::HasSubstr("--set 'look={}'"));
  EXPECT_EQ(run({"look={}"}), "handed_over");
  EXPECT_EQ(run({"bring.max_looks=1"}), "handed_over");
}

TEST(BringTask, SaysThatItIsNotThere) {
  const auto experiment = Open({"arrangement=single", "bring.absent=true"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, kSaidAbsent) << result.data;
  const auto data = DataOf(result);
  EXPECT_FALSE(data["present"]);
  for (const auto& attempt : data["attempts"]) EXPECT_FALSE(attempt["at_wanted"]);
}

}  // namespace
}  // namespace rangegrasp::bring
