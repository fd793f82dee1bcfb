#include "tasks/bring/bring_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "experiment/experiment.h"
#include "tasks/kinds.h"

namespace rangegrasp::tasks::bring {
namespace {

using testing::HasSubstr;

std::string ErrorOf(const std::vector<std::string>& set) {
  try {
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/bring.yaml", AllKinds(),
                               {.set = set});
  } catch (const core::InputError& e) {
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
}  // namespace rangegrasp::tasks::bring
