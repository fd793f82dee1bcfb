#include "base/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace rangegrasp::base {
namespace {

enum class Colour { kRed, kGreen, kBlue };
constexpr std::array<std::string_view, 3> WordsOf(Colour) { return {"red", "green", "blue"}; }

TEST(Words, EveryValueHasItsWordAndComesBack) {
  EXPECT_EQ(Word(Colour::kGreen), "green");
  for (const Colour colour : ValuesOf<Colour>()) {
    EXPECT_EQ(FromWord<Colour>(Word(colour), "colour"), colour);
  }
  EXPECT_THAT(WordList<Colour>(), testing::ElementsAre("red", "green", "blue"));
}

TEST(Words, AnUnknownWordIsToldWithTheNearest) {
  try {
    FromWord<Colour>("grean", "--colour");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "--colour: 'grean' must be one of red, green, blue; nearest: green");
  }
}

TEST(Split, JoinBringsTheTextBack) {
  EXPECT_THAT(Split("a,b,,c", ','), testing::ElementsAre("a", "b", "", "c"));
  EXPECT_THAT(Split("", ','), testing::ElementsAre(""));
  EXPECT_EQ(Join(Split("a,b,,c", ','), ","), "a,b,,c");
}

}  // namespace
}  // namespace rangegrasp::base
