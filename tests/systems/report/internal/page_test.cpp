#include "report/internal/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/file.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing_support::TempFolder;

TEST(PrepareFolder, TouchesNothingThatIsNoReport) {
  const TempFolder folder;
  base::WriteFile(folder / "views/precious.txt", "mine");
  EXPECT_THAT(testing_support::ErrorOf<base::InputError>([&] { PrepareFolder(folder.path()); }),
              HasSubstr("not of a report"));
  EXPECT_EQ(base::ReadFile(folder / "views/precious.txt"), "mine");
}

TEST(PrepareFolder, MayBeLockedByTheCaller) {
  const TempFolder folder;
  const experiment::FolderLock lock(folder.path());
  PrepareFolder(folder.path());
  EXPECT_TRUE(std::filesystem::exists(folder / experiment::FolderLock::kFile));
}

TEST(PrepareFolder, LeavesNoViewOfAnEarlierReport) {
  const TempFolder folder;
  base::WriteFile(folder / "data.js", "");
  base::WriteFile(folder / "views/3.js", "");
  PrepareFolder(folder.path());
  EXPECT_FALSE(std::filesystem::exists(folder / "views"));
}

TEST(PrepareFolder, AReportThatFailedCanBeRepeated) {
  const TempFolder folder;
  const auto report = folder / "report";
  PrepareFolder(report);
  base::WriteFile(report / "views/3.js", "");
  PrepareFolder(report);
  EXPECT_FALSE(std::filesystem::exists(report / "views"));
  WriteData({}, {}, "", report);
  EXPECT_FALSE(std::filesystem::exists(report / "report.unfinished"));
}

// A page that is opened from disk must not load anything from elsewhere.
TEST(WritePage, NamesNoPlaceOutsideTheReport) {
  const TempFolder folder;
  WritePage(folder.path());
  for (const char* file : {"index.html", "report.css", "plots.js", "report.js", "view.js"}) {
    const std::string text = base::ReadFile(folder / file);
    EXPECT_THAT(text, Not(HasSubstr("http"))) << file;
    EXPECT_THAT(text, Not(HasSubstr("innerHTML"))) << file;  // a run's texts stay text
  }
}

// Records of which every tenth has failed.
std::vector<experiment::Record> Records(std::size_t n) {
  std::vector<experiment::Record> records(n);
  for (std::size_t i = 0; i < n; ++i) {
    records[i].result.outcome = i % 10 == 0 ? "dropped" : "delivered";
  }
  return records;
}

TEST(ChooseViews, TakesAllThatFailedAndSixtyOthersFromEndToEnd) {
  const auto chosen = ChooseViews(Records(600), "delivered", ViewChoice::kSome);
  EXPECT_EQ(chosen.size(), 120u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  for (std::size_t i = 0; i < 600; i += 10) {
    EXPECT_TRUE(std::binary_search(chosen.begin(), chosen.end(), i)) << i;
  }
  // The other nine of every ten are left, of which sixty are chosen: one in each stretch of ten.
  for (std::size_t i = 0; i < 600; i += 10) {
    EXPECT_EQ(std::count_if(chosen.begin(), chosen.end(),
                            [&](std::size_t c) { return c > i && c < i + 10; }),
              1)
        << i;
  }
}

TEST(ChooseViews, TakesAllWhereThereAreFewer) {
  EXPECT_EQ(ChooseViews(Records(30), "delivered", ViewChoice::kSome).size(), 30u);
  EXPECT_TRUE(ChooseViews({}, "delivered", ViewChoice::kSome).empty());
}

TEST(ChooseViews, OfManyThatFailedItTakesAHundredFromEndToEnd) {
  std::vector<experiment::Record> records(5000);
  for (auto& record : records) record.result.outcome = "dropped";
  const auto chosen = ChooseViews(records, "delivered", ViewChoice::kSome);
  ASSERT_EQ(chosen.size(), 100u);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(chosen[i] / 50, i);
}

TEST(Fitting, KeepsAsManyAsFitFromEndToEnd) {
  EXPECT_EQ(Fitting({5, 5, 5, 5}, 20).size(), 4u);
  EXPECT_EQ(Fitting({5, 5, 5, 5}, 19).size(), 3u);
  EXPECT_EQ(Fitting({5, 5, 5, 5}, 10), (std::vector<std::size_t>{0, 2}));
  EXPECT_TRUE(Fitting({5, 5}, 4).empty());
  EXPECT_TRUE(Fitting({}, 4).empty());
  EXPECT_EQ(Fitting({0, 0}, 0).size(), 2u);
}

TEST(ChooseViews, WithoutASuccessNoneHasFailed) {
  EXPECT_EQ(ChooseViews(Records(600), "", ViewChoice::kSome).size(), 60u);
}

TEST(ChooseViews, AllAndNone) {
  EXPECT_EQ(ChooseViews(Records(100), "delivered", ViewChoice::kAll).size(), 100u);
  EXPECT_TRUE(ChooseViews(Records(100), "delivered", ViewChoice::kNone).empty());
}

}  // namespace
}  // namespace rangegrasp::report
