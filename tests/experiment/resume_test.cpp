#include "experiment/resume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "error_of.h"
#include "experiment/sample_record.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

using testing::HasSubstr;

// Two objects with so many trials each, as an experiment numbers them.
std::vector<Case> CasesOf(int trials) {
  std::vector<Case> cases;
  for (const char* object : {"mug", "ball"}) {
    for (int i = 0; i < trials; ++i) cases.push_back(SampleCase(object, i));
  }
  for (std::size_t i = 0; i < cases.size(); ++i) cases[i].position = static_cast<int>(i);
  return cases;
}

Stamp ResumeStampOf(std::size_t cases, const std::string& commit = "abc") {
  return {{{"experiment", "demo"}, {"seed", "1"}, {"cases", std::to_string(cases)}},
          {{"version", "0.1"}, {"commit", commit}},
          {{"set", "of " + std::to_string(cases)}}};
}

class ResumeTest : public testing::Test {
 protected:
  ResumeTest() : store_(Store::Create(folder_.path())) {
    store_.WriteStamp(ResumeStampOf(4));
    for (const Case& c : CasesOf(2)) store_.Write({c, SampleResult(c)});
  }

  testing_support::TempFolder folder_;
  Store store_;
};

// The stored rows stand where a run with all cases would have put them.
TEST_F(ResumeTest, MoreTrialsFindTheirPlaceAmongThoseThatAreThere) {
  const auto cases = CasesOf(3);
  const auto before = store_.ReadAll();
  const Stamp stamp = Resume(store_, ResumeStampOf(6), cases);
  EXPECT_EQ(stamp, ResumeStampOf(6));
  const auto after = store_.ReadAll();
  ASSERT_EQ(after.size(), 4u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_TRUE(SameButTimes(before[i], after[i]));
    EXPECT_EQ(before[i].result.seconds, after[i].result.seconds);
    EXPECT_EQ(after[i].which.position, (std::array{0, 1, 3, 4})[i]);
  }
}

TEST_F(ResumeTest, FewerTrialsAreRefusedAndNothingIsChanged) {
  const auto before = store_.ReadAll();
  EXPECT_THAT(testing_support::MessageOf([&] { Resume(store_, ResumeStampOf(2), CasesOf(1)); }),
              HasSubstr("holds the case mug-0001"));
  EXPECT_EQ(store_.ReadStamp(), ResumeStampOf(4));
  const auto after = store_.ReadAll();
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(Row(before[i]), Row(after[i]));
}

TEST_F(ResumeTest, AnotherSeedIsRefused) {
  Stamp other = ResumeStampOf(4);
  other.identity["seed"] = "2";
  EXPECT_THAT(testing_support::MessageOf([&] { Resume(store_, other, CasesOf(2)); }),
              HasSubstr("another seed"));
}

TEST_F(ResumeTest, TheCommitThatBeganTheRunStays) {
  Stamp stamp = Resume(store_, ResumeStampOf(4, "def"), CasesOf(2));
  EXPECT_EQ(stamp.build.at("commit"), "abc");
  EXPECT_EQ(stamp.build.at("resumed_with"), "def");
  store_.WriteStamp(stamp);
  stamp = Resume(store_, ResumeStampOf(4, "def"), CasesOf(2));
  EXPECT_EQ(stamp.build.at("resumed_with"), "def");
  store_.WriteStamp(stamp);
  EXPECT_EQ(Resume(store_, ResumeStampOf(4), CasesOf(2)).build.at("commit"), "abc");
}

}  // namespace
}  // namespace rangegrasp::experiment
