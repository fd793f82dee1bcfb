// One command runs published tables; here a few trials of a few tables.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <exception>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using experiment::Store;
using nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing_support::Command;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

std::vector<std::string> Arguments(const std::string& out, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"reproduce", "--short", "5.2", "--jobs", "2", "-o", out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// The number of finished cases of a run in progress; 0 while its store is being created.
int CountIn(const std::filesystem::path& folder) {
  try {
    return Store::Exists(folder) ? Store::Open(folder).Count() : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

// Makes one uninterrupted run for all tests.
class ReproduceTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    reference_ = new Ran(RunProgram(Arguments(Folder("reference"), {})));
  }
  static void TearDownTestSuite() {
    delete reference_;
    delete shared_;
  }
  void SetUp() override { ASSERT_EQ(reference_->code, 0) << reference_->err; }

  static std::string Folder(const std::string& name) { return (*shared_ / name).string(); }
  static std::string Page(const std::string& name) {
    return base::ReadFile(*shared_ / name / "reproduced.md");
  }

  static inline TempFolder* shared_ = nullptr;
  static inline Ran* reference_ = nullptr;
};

// 12 objects with two figures each, plus the two overall figures.
TEST_F(ReproduceTest, PutsEachPublishedFigureBesideTheTablesOwn) {
  EXPECT_EQ(reference_->out, Page("reference"));
  EXPECT_THAT(reference_->out, HasSubstr("shows only that everything runs"));
  EXPECT_THAT(reference_->out, Not(HasSubstr("Fisher's exact test")));
  EXPECT_THAT(reference_->err, HasSubstr("table 5.2: 12 cases"));
  const Ran again = RunProgram(Arguments(Folder("reference"), {"--json"}));
  const auto page = json::parse(again.out);
  const auto& rows = page["tables"][1]["rows"];  // of row, published, reproduced, ...
  ASSERT_EQ(rows.size(), 26u);
  const Ran table = RunProgram({"table", Folder("reference/laser_single"), "--json"});
  const auto own = json::parse(table.out);
  constexpr double kRounded = 0.0501;  // to one digit
  for (std::size_t i = 0; i <= 12; ++i) {
    const auto& row = i < 12 ? own["rows"][i] : own["overall"];
    EXPECT_NEAR(rows[2 * i][1].get<double>(), 100.0 * row["published_detection_rate"].get<double>(),
                kRounded);
    EXPECT_NEAR(rows[2 * i][2].get<double>(), 100.0 * row["detection_rate"].get<double>(),
                kRounded);
  }
}

TEST_F(ReproduceTest, ARunThatWasKilledGoesOnAndEndsWithTheSamePage) {
  {
    Command killed(Arguments(Folder("killed"), {}));
    const std::filesystem::path store = Folder("killed/laser_single");
    while (killed.Runs() && CountIn(store) < 3) {
      usleep(10'000);
    }
    killed.Kill();
  }
  const int before = Store::Open(Folder("killed/laser_single")).Count();
  ASSERT_LT(before, 12);
  const Ran ran = RunProgram(Arguments(Folder("killed"), {}));
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("12 cases, " + std::to_string(before) + " of them done"));
  EXPECT_THAT(ran.err, HasSubstr(std::to_string(12 - before) + " cases in"));
  EXPECT_EQ(Page("killed"), Page("reference"));
}

TEST_F(ReproduceTest, WhatCannotBeRunIsLeftOutWithItsReasonAndNotCounted) {
  const auto arguments = Arguments(Folder("reference"), {"6.1", "--psb", "/no/such/folder"});
  const Ran ran = RunProgram(arguments);
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("6.1 is left out: "));
  EXPECT_THAT(ran.out, HasSubstr("--psb: '/no/such/folder' has no folder 'off'"));
  EXPECT_THAT(ran.out, ContainsRegex("\\| 6\\.1 \\|[^\n]*\\| left out \\|"));
  EXPECT_THAT(ran.out, Not(HasSubstr("Table 6.1:")));
  // Fails because no other table was requested.
  EXPECT_EQ(RunProgram({"reproduce", "6.1", "--psb", "/no/such/folder", "-o", Folder("none")}).code,
            2);
  ASSERT_EQ(RunProgram(Arguments(Folder("reference"), {})).code, 0);  // for the other tests
}

TEST_F(ReproduceTest, AnUnknownTableIsToldBeforeAnythingIsRun) {
  testing_support::ExpectRefused({"reproduce", "5.7", "-o", Folder("unknown")},
                                 "'5.7' must be one of 3.1");
  EXPECT_FALSE(std::filesystem::exists(Folder("unknown")));
}

// A command for another table keeps the first one's on the page.
TEST_F(ReproduceTest, ThePageHoldsTheTablesOfEarlierCommands) {
  std::filesystem::create_directories(Folder("both"));
  std::filesystem::copy(Folder("reference/laser_single"), Folder("both/laser_single"),
                        std::filesystem::copy_options::recursive);
  const Ran ran = RunProgram({"reproduce", "--short", "5.3", "--jobs", "2", "-o", Folder("both")});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(Page("both"), ContainsRegex("\\| 5\\.2 \\|[^\n]*\\| done \\| 12 \\| 26 \\|"));
  EXPECT_LT(Page("both").find("Table 5.2:"), Page("both").find("Table 5.3:"));
}

TEST_F(ReproduceTest, SeveralSeedsStandInOneTable) {
  const Ran ran = RunProgram(Arguments(Folder("seeds"), {"--seeds", "1,2"}));
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(Page("seeds"), HasSubstr("| done | 24 |"));
}

}  // namespace
}  // namespace rangegrasp
