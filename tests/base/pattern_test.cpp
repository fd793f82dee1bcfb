#include "base/pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rangegrasp::base {
namespace {

using testing::ElementsAre;

TEST(Pattern, TheFirstMatchHasItsPlaceAndGroups) {
  const auto match = FindMatch("mass='2' size='3'", "(\\w+)='(\\d)'( |$)|never(x)");
  ASSERT_TRUE(match);
  EXPECT_EQ(match->begin, 0U);
  EXPECT_EQ(match->end(), 9U);
  EXPECT_THAT(match->groups, ElementsAre("mass='2' ", "mass", "2", " ", ""));
}

TEST(Pattern, ASearchBeginsAtAPlaceAndCountsFromTheBeginningOfTheText) {
  const std::string text = "ab ab";
  EXPECT_EQ(FindMatch(text, "ab", 1)->begin, 3U);
  EXPECT_FALSE(FindMatch(text, "ab", 4));
  EXPECT_FALSE(FindMatch(text, "x"));
}

TEST(Pattern, AllMatchesDoNotOverlap) {
  std::vector<std::size_t> places;
  for (const Match& match : AllMatches("aaa baa", "aa")) places.push_back(match.begin);
  EXPECT_THAT(places, ElementsAre(0, 5));
  EXPECT_THAT(AllMatches("", "aa"), ElementsAre());
}

}  // namespace
}  // namespace rangegrasp::base
