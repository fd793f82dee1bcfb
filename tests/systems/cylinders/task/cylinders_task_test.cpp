#include "cylinders/task/cylinders_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "error_of.h"
#include "experiment/experiment.h"
#include "experiment/runner.h"
#include "experiment/store.h"
#include "temp_folder.h"

namespace rangegrasp::cylinders {
namespace {

using testing::HasSubstr;
using testing_support::ErrorOf;

experiment::Experiment Open(const std::string& name, const std::vector<std::string>& set = {}) {
  std::vector<std::string> all = {R"(rows=["10, 100, 1000"])", "repetitions=1"};
  all.insert(all.end(), set.begin(), set.end());
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/" + name,
                                    {.set = all, .seed = 11});
}

TEST(CylindersTask, RunsBothExperimentsEndToEnd) {
  for (const std::string name : {"cylinder_resolution.yaml", "cylinder_iterations.yaml"}) {
    const auto experiment = Open(name, {"iterations=[100]"});
    ASSERT_EQ(experiment.cases.size(), 3u);  // perfect, noisy, scanned
    std::vector<experiment::Record> records;
    for (const auto& which : experiment.cases) {
      records.push_back({which, experiment.task->Run(which)});
      EXPECT_EQ(records.back().result.outcome, "fitted");
    }
    const auto report = CylindersTask().report(experiment.stamp, records);
    EXPECT_EQ(report.sections.size(), 3u);
    EXPECT_EQ(report.csv.rows.size(), 15u);
  }
}

TEST(CylindersTask, IterationsAreWholeNumbers) {
  for (const std::string wrong : {"[0]", "[10.7]", "['100, 200']", "[100001]"}) {
    EXPECT_THAT(ErrorOf([&] { Open("cylinder_iterations.yaml", {"iterations=" + wrong}); }),
                HasSubstr("must be a whole number from 1 to 100000"))
        << wrong;
  }
}

TEST(CylindersTask, TheRefinedFitOfPerfectPointsIsExact) {
  const auto experiment = Open("cylinder_resolution.yaml", {"sources=[perfect]"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  const auto fits = nlohmann::json::parse(result.data).at("fits");
  EXPECT_EQ(fits.back().at("method"), "refined");
  EXPECT_LT(fits.back().at("radius_error_mm"), 1e-5);
  EXPECT_LT(fits.back().at("axis_error_deg"), 1e-4);
}

TEST(CylindersTask, SameSeedSameRecordsForOneAndTwoJobs) {
  const auto experiment =
      Open("cylinder_resolution.yaml", {"repetitions=2", "methods=[lsf, rcf, refined]"});
  std::vector<std::vector<experiment::Record>> runs;
  for (const int jobs : {1, 2}) {
    const testing_support::TempFolder folder;
    auto store = experiment::Store::Create(folder.path());
    experiment::RunCases(experiment.cases,
                         [&](const experiment::Case& which) { return experiment.task->Run(which); },
                         store, {.jobs = jobs}, {});
    runs.push_back(store.ReadAll());
  }
  ASSERT_EQ(runs[0].size(), experiment.cases.size());
  ASSERT_EQ(runs[1].size(), experiment.cases.size());
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_TRUE(experiment::SameButTimes(runs[0][i], runs[1][i])) << runs[0][i].which.id;
  }
}

TEST(CylindersTask, SaysWhatIsWrongWithARow) {
  const auto error = [](const std::string& row) {
    return testing_support::ErrorOf(
        [&] { Open("cylinder_resolution.yaml", {"rows=[\"" + row + "\"]"}); });
  };
  EXPECT_THAT(error("0, 100, 1000"), HasSubstr("'0, 100, 1000' must be radius in mm"));
  EXPECT_THAT(error("10, 100"), HasSubstr("'10, 100' must be"));
  EXPECT_THAT(error("10, x, 1000"), HasSubstr("is not a number"));
  EXPECT_THAT(error("10, 100, 3"), HasSubstr("points"));
}

}  // namespace
}  // namespace rangegrasp::cylinders
