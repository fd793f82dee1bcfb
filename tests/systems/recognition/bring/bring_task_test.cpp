#include "recognition/task/bring_task.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiment/experiment.h"

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
