#include "base/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "base/error.h"
#include "base/rng.h"
#include "error_of.h"

namespace rangegrasp::base {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;

TEST(CsvTable, ReadsQuotedCellsAndBothLineEnds) {
  const auto table = CsvTable::Parse("a,b\r\n\"x, \"\"y\"\"\",1.5\n\n\"two\nlines\",\n", "t.csv");
  EXPECT_THAT(table.header(), testing::ElementsAre("a", "b"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.Cell(0, 0), "x, \"y\"");
  EXPECT_EQ(table.Number(0, table.Column("b")), 1.5);
  EXPECT_EQ(table.Cell(1, 0), "two\nlines");
  EXPECT_EQ(table.OptionalNumber(1, 1), std::nullopt);
}

TEST(CsvTable, NamesFileLineColumnAndCell) {
  const auto table = CsvTable::Parse("name,n\nx,1\ny,one\n", "t.csv");
  EXPECT_THAT(ErrorOf([&] { table.Number(1, 1); }), HasSubstr("t.csv:3: column 'n': 'one' must"));
  EXPECT_THAT(ErrorOf([&] { table.Column("nam"); }), HasSubstr("nearest: name"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("a,b\n1\n", "t.csv"); }), HasSubstr("t.csv:2: has 1"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("a\n\"x\n\n", "t.csv"); }),
              HasSubstr("t.csv:2: a quote"));
  EXPECT_THAT(ErrorOf([] { CsvTable::Parse("", "t.csv"); }), HasSubstr("t.csv: is empty"));
}

TEST(CsvTable, ANumberIsAWholeCellAndFinite) {
  for (const std::string bad : {"1.5x", "1 ", "1,5", "inf", "-inf", "nan", "1e999", ""}) {
    const auto table = CsvTable::Parse("n,m\n" + CsvLine({bad, "x"}), "t.csv");
    EXPECT_THAT(ErrorOf([&] { table.Number(0, 0); }), HasSubstr("t.csv:2: column 'n'")) << bad;
  }
  const auto table = CsvTable::Parse("n,m\n-1.5e2,0\n", "t.csv");
  EXPECT_EQ(table.Number(0, 0), -150.0);
  EXPECT_EQ(table.Number(0, 1), 0.0);
}

TEST(CsvLine, IsReadBackTheSame) {
  const std::string letters = "ab,\"\n\r ;";
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Rng rng(seed);
    std::vector<std::string> cells(1 + rng.Index(4));
    for (std::string& cell : cells) {
      for (std::size_t n = rng.Index(6); n > 0; --n) cell += letters[rng.Index(letters.size())];
    }
    cells.push_back("end");  // a line of one empty cell is no line
    const std::vector<std::string> names(cells.size(), "n");
    const auto table = CsvTable::Parse(CsvLine(names) + CsvLine(cells), "t.csv");
    ASSERT_EQ(table.rows(), 1u) << seed;
    for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(table.Cell(0, i), cells[i]) << seed;
  }
}

}  // namespace
}  // namespace rangegrasp::base
