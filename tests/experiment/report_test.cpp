#include "experiment/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::experiment {
namespace {

const Grid kGrid = {{"what", "n"}, {true, false}, {{"a", "1"}, {"long word", "10"}}, true};

TEST(PublishedText, IsATableWithRows) {
  const testing_support::TempFolder folder;
  const auto file = folder.Write("t.csv", "method,a\nours,1\n");
  EXPECT_EQ(PublishedText(file), "method,a\nours,1\n");
  for (const auto& [text, what] : {std::pair("", "is empty"), std::pair("method,a\n", "no row")}) {
    folder.Write("t.csv", text);
    EXPECT_THAT(
        testing_support::ErrorOf([&] { PublishedText(file); }),
        testing::AllOf(testing::StartsWith(file.string() + ": "), testing::HasSubstr(what)));
  }
}

TEST(Column, WritesMembersAndFunctionsAndLeavesOutWhatIsAbsent) {
  struct Fit {
    std::string name;
    int points;
    std::optional<double> error;
  };
  const std::vector<Column<Fit>> columns = {
      {"method", "", &Fit::name, kLeft},
      {"points", "", &Fit::points},
      {"error", ".2f", &Fit::error},
      {"half", ".1f", [](const Fit& fit) { return fit.points / 2.0; }}};
  const std::vector<Fit> fits = {{"LSF", 3, 0.125}, {"RCF", 4, std::nullopt}};
  const Grid grid = GridOf(columns, fits);
  EXPECT_EQ(grid.header, (std::vector<std::string>{"method", "points", "error", "half"}));
  EXPECT_EQ(grid.left, (std::vector<bool>{true, false, false, false}));
  EXPECT_EQ(grid.rows, (std::vector<std::vector<std::string>>{{"LSF", "3", "0.12", "1.5"},
                                                              {"RCF", "4", "-", "2.0"}}));
  EXPECT_EQ(GridOf(columns, fits, "").rows[1][2], "");
}

TEST(Grid, TextAlignsWordsLeftAndNumbersRight) {
  EXPECT_EQ(TextOf(kGrid),
            "what        n\n"
            "-------------\n"
            "a           1\n"
            "-------------\n"
            "long word  10\n");
}

TEST(Grid, LinesEndWithoutBlanks) {
  const Grid grid = {{"n", "what"}, {false, true}, {{"1", "a"}, {"10", "long word"}}, false};
  EXPECT_EQ(TextOf(grid),
            " n  what\n"
            "--------\n"
            " 1  a\n"
            "10  long word\n");
}

TEST(Grid, TitlesAreNoWiderThanTheirWordsOrTheValues) {
  const Grid grid = {{"object", "detection (text) %", "of all runs"},
                     {true, false, false},
                     {{"a cup", "94.2", "1,234 of 2,000"}},
                     false};
  EXPECT_EQ(TextOf(grid),
            "        detection\n"
            "object   (text) %     of all runs\n"
            "---------------------------------\n"
            "a cup        94.2  1,234 of 2,000\n");
}

TEST(Format, TablesAreJsonWithNumbersAndNullForNothing) {
  Report report;
  report.sections = {
      {"sizes", {{"what", "n"}, {true, false}, {{"a", "1.5"}, {"1x", "-"}, {"", "2"}}, false}}};
  const auto json = nlohmann::json::parse(Format(report, {}, TableFormat::kJson));
  EXPECT_EQ(json["tables"][0]["title"], "sizes");
  EXPECT_EQ(json["tables"][0]["rows"],
            nlohmann::json::parse(R"([["a", 1.5], ["1x", null], [null, 2]])"));
}

TEST(Format, CsvIsTheOneTableThatIsMeantForIt) {
  Report report;
  report.sections = {{"", kGrid}};
  EXPECT_EQ(Format(report, {}, TableFormat::kCsv), CsvOf(kGrid) + "\n");
  report.csv = {{"x"}, {}, {{"1"}}, false};
  EXPECT_EQ(Format(report, {}, TableFormat::kCsv), "x\n1\n");
}

TEST(Grid, MarkdownSaysHowColumnsAlign) {
  EXPECT_EQ(MarkdownOf(kGrid), "| what | n |\n| --- | ---: |\n| a | 1 |\n| long word | 10 |\n");
}

TEST(Grid, MarkdownKeepsABarWithinACellApartFromTheColumns) {
  const Grid grid = {{"mean |error|"}, {false}, {{"1"}}, false};
  EXPECT_EQ(MarkdownOf(grid), "| mean \\|error\\| |\n| ---: |\n| 1 |\n");
}

TEST(Grid, CsvQuotesOnlyWhatNeedsIt) {
  Grid grid = kGrid;
  grid.rows = {{"a, \"b\"", "1"}};
  EXPECT_EQ(CsvOf(grid), "what,n\n\"a, \"\"b\"\"\",1\n");
}

TEST(Grid, NumbersAreRoundedAndIntervalsAreWilsons) {
  EXPECT_EQ(Fixed(1.005, 1), "1.0");
  EXPECT_EQ(Fixed(-2.25, 0), "-2");
  EXPECT_EQ(IntervalText(0, 0), "-");
  EXPECT_EQ(IntervalText(10, 10), "72-100");  // 10 / (10 + 1.96^2) = 0.7225
}

}  // namespace

}  // namespace rangegrasp::experiment
