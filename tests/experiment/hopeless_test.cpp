#include "experiment/hopeless.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/sample_record.h"

namespace rangegrasp::experiment {
namespace {

using testing::ElementsAre;

Record Ended(int i, const std::string& outcome, const std::string& stage,
             const std::string& detail) {
  Record record = SampleRecord("cup", i);
  record.result.outcome = outcome;
  record.result.stage = stage;
  record.result.detail = detail;
  return record;
}

TEST(InTurn, TakesOneOfEachGroupAfterTheOther) {
  std::vector<Case> cases;
  for (const char* group : {"a", "b", "c"}) {
    for (int i = 0; i < (group[0] == 'b' ? 1 : 3); ++i) cases.push_back(SampleCase(group, i));
  }
  std::vector<std::string> ids;
  for (const Case& c : InTurn(cases)) ids.push_back(c.id);
  EXPECT_THAT(ids,
              ElementsAre("a-0000", "b-0000", "c-0000", "a-0001", "c-0001", "a-0002", "c-0002"));
}

TEST(SameFailure, SaysWhatAllHaveInCommonWithTheirMostFrequentDetail) {
  const std::vector<Record> records = {Ended(0, "no_path", "plan", "no_ik x3"),
                                       Ended(1, "no_path", "plan", "no_ik x24"),
                                       Ended(2, "no_path", "plan", "no_ik x24")};
  EXPECT_EQ(SameFailure(records, "delivered"), "no_path in plan: no_ik x24");
}

TEST(SameFailure, IsNoneWhereOneSucceedsOrFailsOtherwise) {
  const Record failed = Ended(0, "no_path", "plan", "");
  EXPECT_TRUE(SameFailure({failed, failed}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "delivered", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "dropped", "plan", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({failed, Ended(1, "no_path", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({Ended(0, "delivered", "score", "")}, "delivered"));
  EXPECT_FALSE(SameFailure({}, "delivered"));
}

TEST(CrashReasons, AreDistinctAndMostFrequentFirst) {
  EXPECT_THAT(CrashReasons({Ended(0, kCrashed, "scan", "b"), Ended(1, kCrashed, "plan", "a"),
                            Ended(2, "dropped", "score", "c"), Ended(3, kCrashed, "plan", "a"),
                            Ended(4, kCrashed, "", "")}),
              ElementsAre("2 x plan: a", "1 x no reason given", "1 x scan: b"));
}

}  // namespace
}  // namespace rangegrasp::experiment
