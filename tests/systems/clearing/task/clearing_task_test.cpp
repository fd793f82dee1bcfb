#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiment/experiment.h"

namespace rangegrasp::clearing {
namespace {

experiment::Experiment OpenPile(const std::vector<std::string>& set) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/clear_pile.yaml",
                                    {.set = set});
}

int ObjectsOf(const experiment::Experiment& e) { return e.cases.at(0).params.Int("objects"); }

// A run without a record counts them as not delivered.
TEST(ClearingCases, StateTheMaximumNumberOfObjectsOfARun) {
  EXPECT_EQ(ObjectsOf(OpenPile({})), 12);
  const auto drawn = [](const std::string& set) {
    return OpenPile({"clutter.min_others=1", "clutter.max_others=1", set});
  };
  EXPECT_EQ(ObjectsOf(drawn("clutter.draw_others=true")), 2);
  EXPECT_EQ(ObjectsOf(drawn("arrangement=scattered")), 2);
  EXPECT_EQ(ObjectsOf(drawn("arrangement=side_by_side")), 2);
}

// By default a run has as many grasps as its own objects have tries, not those of the experiment.
TEST(ClearingRun, EndsAfterTheTriesOfTheObjectsInIt) {
  const auto e = OpenPile({"arrangement=single", "clearing.tries_per_object=1"});
  const auto data = nlohmann::json::parse(e.task->Run(e.cases.at(0)).data);
  EXPECT_EQ(data["objects"], 1);
  EXPECT_EQ(data["grasps"], 1);
  EXPECT_EQ(data["stop"], "max_grasps");
}

}  // namespace
}  // namespace rangegrasp::clearing
