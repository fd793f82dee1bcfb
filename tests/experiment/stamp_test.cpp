#include "experiment/stamp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "error_of.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;

const Stamp kStamp{
    {{"experiment", "demo"}, {"seed", "1"}}, {{"version", "0.1"}, {"commit", "abc"}}, {}};

std::string StampErrorOf(const Stamp& other) {
  return testing_support::MessageOf([&] { CheckSameRun(other, kStamp, "results/demo"); });
}

TEST(CheckSameRun, NamesWhatDiffers) {
  Stamp other = kStamp;
  other.identity["seed"] = "2";
  EXPECT_THAT(StampErrorOf(other),
              HasSubstr("results/demo: was made with another seed ('2', not '1')"));
}

TEST(CheckSameRun, AValueThatOnlyOneHasIsADifference) {
  Stamp other = kStamp;
  other.identity["scene_hash"] = "x";
  EXPECT_THAT(StampErrorOf(other), HasSubstr("another scene_hash"));
  other = kStamp;
  other.identity.erase("seed");
  EXPECT_THAT(StampErrorOf(other), HasSubstr("another seed"));
}

TEST(CheckSameRun, BuildAndDataMayDiffer) {
  Stamp other = kStamp;
  other.build["commit"] = "def";
  other.data["title.mug"] = "Mug";
  EXPECT_EQ(StampErrorOf(other), "");
}

TEST(Need, SaysThatTheRunWasKilled) {
  EXPECT_EQ(Need(kStamp.identity, "seed"), "1");
  EXPECT_THAT(testing_support::ErrorOf([] { Need(kStamp.identity, "task"); }),
              HasSubstr("no stamp 'task'"));
}

TEST(LineOf, BeginsWithNameVersionAndCommit) {
  EXPECT_EQ(LineOf(kStamp), "demo: rangegrasp 0.1 (abc), seed 1");
  Stamp many = kStamp;
  many.identity["groups"] = "a,b,c";  // a row of the table each
  EXPECT_EQ(LineOf(many), LineOf(kStamp));
}

}  // namespace
}  // namespace rangegrasp::experiment
