#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "error_of.h"
#include "experiment/experiment.h"
#include "experiment/reproduction.h"

namespace rangegrasp::experiment {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::filesystem::path kExperiments = RANGEGRASP_SOURCE_DIR "/experiments";

std::vector<std::string> NumbersOf(const std::vector<std::string>& chosen) {
  std::vector<std::string> numbers;
  for (const PublishedTable& table : ChosenTables(chosen)) numbers.push_back(table.number);
  return numbers;
}

TEST(ChosenTables, AreThoseOfNumbersAndChaptersInTheOrderOfTheBook) {
  EXPECT_THAT(NumbersOf({"5.3", "5.2"}), ElementsAre("5.2", "5.3"));
  EXPECT_THAT(NumbersOf({"6", "4.1"}), ElementsAre("4.1", "6.1"));
  EXPECT_EQ(NumbersOf({}).size(), PublishedTables().size());
}

TEST(ChosenTables, OfAnUnknownNumberNameTheNearest) {
  const std::string error = testing_support::ErrorOf([] { ChosenTables({"5.2", "5.22"}); });
  EXPECT_THAT(error, HasSubstr("'5.22' must be one of 3.1, 3.2"));
  EXPECT_THAT(error, HasSubstr("nearest: 5.2;"));
}

TEST(PublishedTables, HaveEveryTableThatTheProgramKnows) {
  for (const auto& entry : std::filesystem::directory_iterator(kExperiments / "reference")) {
    const std::string file = entry.path().filename().string();
    const std::string number = file.substr(0, file.find('_'));
    EXPECT_TRUE(std::ranges::any_of(PublishedTables(), [&](const PublishedTable& table) {
      return table.number == number;
    })) << file;
  }
}

// The case counts are used to set up a short run and to estimate the remaining time.
TEST(PublishedTables, HaveAsManyCasesAsTheirExperiments) {
  for (const PublishedTable& table : PublishedTables()) {
    // parts_psb needs a data set that is not part of the project.
    if (table.experiment == "parts_psb") continue;
    for (const bool is_short : {false, true}) {
      experiment::Changes changes;
      if (!table.group.empty()) changes.groups = {table.group};
      if (is_short) changes.trials = table.short_trials;
      const auto e =
          experiment::OpenExperiment(kExperiments / (table.experiment + ".yaml"), changes);
      EXPECT_EQ(static_cast<int>(e.cases.size()), table.Cases(is_short)) << table.number;
    }
  }
}

}  // namespace
}  // namespace rangegrasp::experiment
