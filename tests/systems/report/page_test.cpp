#include "report/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
              HasSubstr("no report"));
  EXPECT_EQ(base::ReadFile(folder / "views/precious.txt"), "mine");
}

TEST(PrepareFolder, LeavesNoViewOfAnEarlierReport) {
  const TempFolder folder;
  base::WriteFile(folder / "data.js", "");
  base::WriteFile(folder / "views/3.js", "");
  PrepareFolder(folder.path());
  EXPECT_FALSE(std::filesystem::exists(folder / "views"));
}

// A page that opens from disk may ask for nothing from elsewhere.
TEST(WritePage, NamesNoPlaceOutsideTheReport) {
  const TempFolder folder;
  WritePage(folder.path());
  for (const char* file : {"index.html", "report.css", "plots.js", "report.js", "view.js"}) {
    const std::string text = base::ReadFile(folder / file);
    EXPECT_THAT(text, Not(HasSubstr("http"))) << file;
    EXPECT_THAT(text, Not(HasSubstr("innerHTML"))) << file;  // texts of a run stay text
  }
}

}  // namespace
}  // namespace rangegrasp::report
