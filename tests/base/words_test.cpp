#include "base/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "error_of.h"

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
  EXPECT_EQ(testing_support::ErrorOf([] { FromWord<Colour>("grean", "--colour"); }),
            "--colour: 'grean' must be one of red, green, blue; nearest: green");
}

TEST(NearestWord, APartOfAWordIsNearerThanAShortWord) {
  EXPECT_EQ(NearestWord("cup", {"spread", "box", "coffee_cup"}), "coffee_cup");
  EXPECT_EQ(NearestWord("co", {"box", "coffee_cup"}), "");  // too short to be a part
  EXPECT_EQ(NearestWord("spraed", {"spread", "box"}), "spread");
  EXPECT_EQ(NearestWord("side", {"single", "pile", "side_by_side"}), "side_by_side");
}

TEST(NearestWord, IsNoneIfMoreThanAThirdOfTheLettersAreWrong) {
  const std::vector<std::string> commands = {"run", "table", "view", "status", "perceive"};
  EXPECT_EQ(NearestWord("tables", commands), "table");
  EXPECT_EQ(NearestWord("ran", commands), "run");
  EXPECT_EQ(NearestWord("vew", commands), "view");
  EXPECT_EQ(NearestWord("veiw", commands), "view");  // two of four: a third, rounded up
  EXPECT_EQ(NearestWord("show", commands), "");
  EXPECT_EQ(NearestWord("perceptions", commands), "");
  EXPECT_EQ(NearestWord("percieve", commands), "perceive");
}

TEST(Suggestion, IsEmptyWithoutANearWord) {
  EXPECT_EQ(Suggestion("tabel", {"run", "table"}), "; nearest: 'table'");
  EXPECT_EQ(Suggestion("tabel", {"run", "table"}, "; did you mean '{}'?"),
            "; did you mean 'table'?");
  EXPECT_EQ(Suggestion("nofile", {"run", "table"}), "");
  EXPECT_EQ(MustBeOneOf("nofile", {"run", "table"}), "'nofile' must be one of run, table");
}

TEST(Split, JoinBringsTheTextBack) {
  EXPECT_THAT(Split("a,b,,c", ','), testing::ElementsAre("a", "b", "", "c"));
  EXPECT_THAT(Split("", ','), testing::ElementsAre(""));
  EXPECT_EQ(Join(Split("a,b,,c", ','), ","), "a,b,,c");
}

TEST(Counted, OnlyOneIsSingular) {
  EXPECT_EQ(Counted(0, "grasp"), "0 grasps");
  EXPECT_EQ(Counted(1, "grasp"), "1 grasp");
  EXPECT_EQ(Counted(21, "grasp"), "21 grasps");
}

TEST(NumberFrom, TakesAWholeTextOrNothing) {
  EXPECT_EQ(NumberFrom<int>("-12"), -12);
  EXPECT_EQ(NumberFrom<double>("1.5e-3"), 0.0015);
  EXPECT_TRUE(std::isinf(NumberFrom<double>("inf").value_or(0.0)));
  for (const char* text : {"", " 1", "1 ", "1x", "+1", "one", "0x10", "1,5"}) {
    EXPECT_FALSE(NumberFrom<int>(text)) << text;
    EXPECT_FALSE(NumberFrom<double>(text)) << text;
  }
  EXPECT_FALSE(NumberFrom<int>("1.5"));
}

TEST(NumberFrom, KnowsWhatItsTypeHolds) {
  EXPECT_EQ(NumberFrom<std::int8_t>("127"), 127);
  EXPECT_FALSE(NumberFrom<std::int8_t>("128"));
  EXPECT_FALSE(NumberFrom<unsigned>("-1"));
  EXPECT_FALSE(NumberFrom<double>("1e999"));
}

TEST(IsUtf8, TakesEveryCharacterAndNothingElse) {
  for (const char* text : {"", "cup", "caf\u00e9", "\u20ac", "\U0001f916", "\U0010ffff"}) {
    EXPECT_TRUE(IsUtf8(text)) << text;
  }
  // Latin-1, truncated, overlong (two), a surrogate, above U+10FFFF, and bytes that are invalid.
  for (const char* text : {"caf\xe9", "\xe2\x82", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80",
                           "\xf4\x90\x80\x80", "\xff", "\x80"}) {
    EXPECT_FALSE(IsUtf8(text)) << text;
  }
}

TEST(Excerpt, IsShortOnOneLineAndOfWholeLetters) {
  EXPECT_EQ(Excerpt("a\nb\tc"), "a b c");
  EXPECT_EQ(Excerpt(std::string(80, 'x')), std::string(80, 'x'));
  EXPECT_EQ(Excerpt(std::string(81, 'x')), std::string(80, 'x') + "...");
  EXPECT_EQ(Excerpt(std::string(79, 'x') + "\u00e4y"), std::string(79, 'x') + "...");
}

}  // namespace
}  // namespace rangegrasp::base
