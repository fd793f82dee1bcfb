#include "experiment/record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error_of.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;
using testing_support::MessageOf;

const Stamp kStamp{
    {{"experiment", "demo"}, {"seed", "1"}}, {{"version", "0.1"}, {"commit", "abc"}}, {}};

std::string StampErrorOf(const Stamp& other) {
  return MessageOf([&] { CheckSameRun(other, kStamp, "results/demo", "do that"); });
}

TEST(Params, AreReadBackTheSameInTheirOrder) {
  const Params params = {{"seam", 3}, {"noise", 2.0}, {"a", "wave, \"slow\""}};
  EXPECT_EQ(ToJson(params), R"({"seam":3,"noise":2.0,"a":"wave, \"slow\""})");
  EXPECT_EQ(Params::FromJson(ToJson(params)), params);
  EXPECT_EQ(Params::FromJson("{}"), Params());
}

TEST(Params, AreTakenByNameAndType) {
  const Params params = {{"seam", 3}, {"noise", 2.0}, {"shape", "wave"}};
  EXPECT_EQ(params.Int("seam"), 3);
  EXPECT_EQ(params.Number("noise"), 2.0);
  EXPECT_EQ(params.Text("shape"), "wave");
  EXPECT_TRUE(params.Has("seam"));
  EXPECT_FALSE(params.Has("run"));
  EXPECT_THAT(MessageOf([&] { params.Int("run"); }), HasSubstr("lack 'run', or its type is wrong"));
  EXPECT_THAT(MessageOf([&] { params.Int("shape"); }),
              HasSubstr("lack 'shape', or its type is wrong"));
}

TEST(Params, ADamagedTextIsRefused) {
  for (const char* text : {"", "{", "[1]x", R"({"a": [1]})", R"({"a": null})"}) {
    EXPECT_THAT(MessageOf([&] { Params::FromJson(text); }), HasSubstr("damaged")) << text;
  }
}

TEST(Params, ADamagedValueIsNamedInShort) {
  const auto error_of = [](const std::string& text) {
    return MessageOf([&] { Params::FromJson(text); });
  };
  EXPECT_THAT(error_of(R"({"seam": 3, "run": null})"), HasSubstr("'run' is null; it must be a"));
  EXPECT_THAT(error_of(R"({"run": 9223372036854775808})"), HasSubstr("'run' is 922337"));
  EXPECT_THAT(error_of("[1]"), HasSubstr("'[1]' is no JSON object"));
  EXPECT_THAT(error_of(R"({"run": [")" + std::string(5000, 'x') + "\"]}"),
              HasSubstr("'run' is array; it must be"));
  EXPECT_LT(error_of(std::string(5000, 'x')).size(), 250u);
}

TEST(Params, ANumberThatDoesNotFitIsRefused) {
  const Params params = {{"seam", std::int64_t{1} << 40}};
  EXPECT_THAT(MessageOf([&] { params.Int("seam"); }), HasSubstr("'seam' is 1099511627776"));
}

TEST(CheckSameRun, NamesWhatDiffers) {
  Stamp other = kStamp;
  other.identity["seed"] = "2";
  EXPECT_EQ(StampErrorOf(other),
            "results/demo: contains results of another run (seed 2 instead of 1); do that");
}

TEST(CheckSameRun, AValueThatOnlyOneHasIsADifference) {
  Stamp other = kStamp;
  other.identity["scene_hash"] = "x";
  EXPECT_THAT(StampErrorOf(other), HasSubstr("scene_hash x instead of none"));
  other = kStamp;
  other.identity.erase("seed");
  EXPECT_THAT(StampErrorOf(other), HasSubstr("seed none instead of 1"));
}

TEST(CheckSameRun, AnotherExperimentIsNamedByWhatWasSet) {
  Stamp other = kStamp;
  other.identity["experiment_hash"] = "x";
  EXPECT_THAT(StampErrorOf(other), HasSubstr("(the experiment files differ)"));
  other.data["set"] = "hand.initial_force_n=40\nseed=1";
  EXPECT_THAT(StampErrorOf(other), HasSubstr("(--set: hand.initial_force_n=40 instead of none)"));
}

TEST(CheckSameRun, AChangedExperimentFileIsNamedByTheLinesThatDiffer) {
  Stamp stored = kStamp, wanted = kStamp;
  stored.identity["experiment_hash"] = "x";
  stored.data = {{"experiment_text", "# A demo.\nseed: 1\nplanner:\n  runs: 3\nhand: three\n"}};
  wanted.data = {{"experiment_text", "seed: 2\nplanner:\n  runs: 4\nhand: three\n"}};
  EXPECT_THAT(MessageOf([&] { CheckSameRun(stored, wanted, "results/demo", "do that"); }),
              HasSubstr("(the experiment files differ: runs: 3 instead of runs: 4)"));
  wanted.data = {{"experiment_text", "seed: 2\r\nplanner:\r\n  runs: 3\r\n\n # Why.\nhand: three"}};
  EXPECT_EQ(MessageOf([&] { CheckSameRun(stored, wanted, "results/demo", "do that"); }), "");
  wanted.data = {{"experiment_text", "planner:\nhand: three\n  runs: 3\n"}};
  EXPECT_THAT(MessageOf([&] { CheckSameRun(stored, wanted, "results/demo", "do that"); }),
              HasSubstr("(the experiment files differ in their order)"));
  wanted.data = {{"experiment_text", "seed: 2\na: 1\nb: 2\nc: 3\nd: 4\ne: 5\n"}};
  EXPECT_THAT(
      MessageOf([&] { CheckSameRun(stored, wanted, "results/demo", "do that"); }),
      HasSubstr("differ: planner:, runs: 3, hand: three instead of a: 1, b: 2, c: 3, ...)"));
}

// Seed and number of trials are no part of the hash, so they do not explain another one.
TEST(CheckSameRun, ANumberOfTrialsIsNotNamedAsTheDifferenceOfFiles) {
  Stamp stored = kStamp, wanted = kStamp;
  stored.identity["experiment_hash"] = "x";
  stored.data["set"] = "runs=1\nseed=1";
  wanted.data = {{"set", "runs=2\nseed=2"}, {kTrialsKey, "runs"}};
  EXPECT_THAT(MessageOf([&] { CheckSameRun(stored, wanted, "results/demo", "do that"); }),
              HasSubstr("(the experiment files differ)"));
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
  many.identity["groups"] = "a,b,c";  // each is a row of the table
  EXPECT_EQ(LineOf(many), LineOf(kStamp));
}

}  // namespace

}  // namespace rangegrasp::experiment
