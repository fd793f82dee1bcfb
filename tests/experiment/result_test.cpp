#include "experiment/result.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "core/error.h"
#include "experiment/sample_result.h"

namespace rangegrasp::experiment {
namespace {

using namespace std::string_literals;

void ExpectEqual(const TrialResult& a, const TrialResult& b) {
  EXPECT_EQ(Row(a), Row(b));
  EXPECT_EQ(a.seconds, b.seconds);
}

TEST(Outcome, EveryOneHasItsOwnNameAndComesBackFromIt) {
  std::set<std::string> names;
  for (const Outcome outcome : AllOutcomes()) {
    EXPECT_EQ(OutcomeFrom(Name(outcome)), outcome);
    names.insert(Name(outcome));
  }
  EXPECT_EQ(names.size(), 11u);
  EXPECT_THROW(OutcomeFrom("success"), core::InputError);
}

TEST(TrialResultJson, RoundTripsExactly) {
  for (int i = 0; i < 50; ++i) {
    const TrialResult result = SampleResult({"mug", i});
    ExpectEqual(FromJson(ToJson(result)), result);
  }
}

TEST(TrialResultJson, RoundTripsExtremesAndOddText) {
  TrialResult result = SampleResult({"mug", 1});
  result.seed = std::numeric_limits<std::uint64_t>::max();
  result.index = std::numeric_limits<int>::max();
  result.redraws = std::numeric_limits<int>::min();
  result.detail = "quote \" backslash \\ newline \n tab \t nul \0 end"s;
  result.stage = "\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80";  // UTF-8 of two, three and four bytes
  result.object = "";
  result.seconds = {{"", 0.1}, {"a", 5e-324}, {"a", 1.7976931348623157e308}, {"b", -0.0}};
  ExpectEqual(FromJson(ToJson(result)), result);
}

TEST(TrialResultJson, InvalidUtf8IsReplacedRatherThanLost) {
  TrialResult result = SampleResult({"mug", 1});
  result.detail = "before \xff\xfe after";
  const TrialResult back = FromJson(ToJson(result));
  EXPECT_EQ(back.detail, "before \xef\xbf\xbd\xef\xbf\xbd after");
  EXPECT_EQ(back.log, result.log);
}

TEST(TrialResultJson, AnythingElseIsARunError) {
  const std::string good = ToJson(SampleResult({"mug", 1}));
  for (std::size_t cut = 0; cut < good.size(); ++cut) {
    EXPECT_THROW(FromJson(good.substr(0, cut)), core::RunError) << cut;
  }
  for (const char* bad : {"{}", "[]", "null", "3", "\xff", "{\"id\": 3}"}) {
    EXPECT_THROW(FromJson(bad), core::RunError) << bad;
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THROW(FromJson(good + good), core::RunError);
  EXPECT_THROW(FromJson(with("\"index\":1", "\"index\":\"1\"")), core::RunError);
  EXPECT_THROW(FromJson(with("not_segmented", "vanished")), core::RunError);
}

}  // namespace
}  // namespace rangegrasp::experiment
