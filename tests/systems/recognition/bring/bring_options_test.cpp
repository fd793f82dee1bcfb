#include "recognition/bring/bring_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"

namespace rangegrasp::bring {
namespace {

using testing::HasSubstr;

std::string ErrorOf(const std::vector<std::string>& set) {
  try {
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/bring.yaml",
                               experiment::AllKinds(), {.set = set});
  } catch (const base::InputError& e) {
    return e.what();
  }
  return "";
}

TEST(BringOptions, KeysOfOtherTasksAreSentToTheirOwn) {
  EXPECT_THAT(ErrorOf({"trials_per_object=3"}), HasSubstr("runs_per_object"));
  EXPECT_THAT(ErrorOf({"views=2"}), HasSubstr("bring.max_looks"));
  EXPECT_THAT(ErrorOf({"grasp.take=handle"}), HasSubstr("task: grasping"));
}

TEST(BringOptions, WhatIsWantedMustBeKnown) {
  EXPECT_THAT(ErrorOf({"known=[spread, cleaner]"}), HasSubstr("salt_cylinder"));
}

}  // namespace
}  // namespace rangegrasp::bring
