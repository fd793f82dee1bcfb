#include "report/parts_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "temp_folder.h"

namespace rangegrasp::report {
namespace {

using parts::BenchmarkOptions;
using parts::BenchmarkRow;
using parts::Method;
using parts::Split;
using testing::HasSubstr;
using testing::Not;
using testing_support::TempFolder;

class PartsTable : public testing::Test {
 protected:
  PartsTable() {
    options_.name = "two classes";
    options_.file = folder_.Write("parts.yaml", "name: two classes\n");
    options_.classes = {{"cup", {1}, {2, 3}}, {"bird", {4}, {5}}};
    options_.methods = {Method::kMirror, Method::kSdf};
    options_.runtimes = folder_.Write(
        "6.1.csv", "method,average_s\nSDF,8.0\nProposed Method,4.2\nCore Extraction,19.5\n");
    Add("cup", 1, Split::kTune, {0.9, 0.9});
    Add("cup", 2, Split::kReport, {0.1, 0.3});
    Add("cup", 3, Split::kReport, {0.3, 0.5});
    Add("bird", 4, Split::kTune, {0.7, 0.7});
    Add("bird", 5, Split::kReport, {0.6, 0.2});
  }

  // The cut discrepancy is twice the Rand error, the time as many seconds as the id.
  void Add(const std::string& name, int id, Split split, const std::vector<double>& errors) {
    for (std::size_t m = 0; m < errors.size(); ++m) {
      BenchmarkRow row;
      row.class_name = name;
      row.id = id;
      row.split = split;
      row.method = options_.methods[m];
      row.parts = 4;
      row.rand_error = errors[m];
      row.cut_discrepancy = 2.0 * errors[m];
      row.seconds = id;
      rows_.push_back(row);
    }
  }
  BenchmarkRow& Row(int id, Method method) {
    return *std::find_if(rows_.begin(), rows_.end(), [&](const BenchmarkRow& row) {
      return row.id == id && row.method == method;
    });
  }
  nlohmann::json Tables() const {
    return nlohmann::json::parse(FormatParts(options_, rows_, TableFormat::kJson))["tables"];
  }

  TempFolder folder_;
  BenchmarkOptions options_;
  std::vector<BenchmarkRow> rows_;
};

TEST_F(PartsTable, MeansOfTheReportSplitLeaveOutWhatWasTunedOn) {
  const auto means = MeansOf(options_, rows_, PartsMetric::kRandError, Split::kReport);
  EXPECT_NEAR(means.by_class[0][0].value(), 0.2, 1e-12);
  EXPECT_NEAR(means.by_class[1][0].value(), 0.4, 1e-12);
  EXPECT_NEAR(means.by_class[0][1].value(), 0.6, 1e-12);
  // Of the classes, however many models each has.
  EXPECT_NEAR(means.overall[0].value(), 0.4, 1e-12);
  EXPECT_NEAR(means.overall[1].value(), 0.3, 1e-12);
  const auto all = MeansOf(options_, rows_, PartsMetric::kRandError, std::nullopt);
  EXPECT_NEAR(all.by_class[0][0].value(), 1.3 / 3.0, 1e-12);
}

TEST_F(PartsTable, AFailedModelDoesNotCount) {
  Row(3, Method::kMirror).failed = true;
  Row(3, Method::kMirror).rand_error = 0.0;
  Row(3, Method::kMirror).note = "off/3.off: no such file";
  const auto means = MeansOf(options_, rows_, PartsMetric::kRandError, Split::kReport);
  EXPECT_NEAR(means.by_class[0][0].value(), 0.1, 1e-12);
  const std::string text = FormatParts(options_, rows_, TableFormat::kText);
  EXPECT_THAT(text, HasSubstr("off/3.off: no such file"));
  EXPECT_EQ(Tables().back()["rows"][0][1], 3);
}

TEST_F(PartsTable, AClassWithoutACutHasNoDiscrepancyAndDoesNotCountInTheMean) {
  for (const int id : {2, 3}) Row(id, Method::kMirror).cut_discrepancy.reset();
  const auto means = MeansOf(options_, rows_, PartsMetric::kCutDiscrepancy, Split::kReport);
  EXPECT_FALSE(means.by_class[0][0]);
  EXPECT_NEAR(means.overall[0].value(), 1.2, 1e-12);
  EXPECT_TRUE(means.by_class[1][0]);
  EXPECT_EQ(PartsMeansCsv(means, PartsMetric::kCutDiscrepancy),
            "class,method,cut_discrepancy\ncup,mirror,\ncup,sdf,0.800000\nbird,mirror,1.200000\n"
            "bird,sdf,0.400000\noverall,mirror,1.200000\noverall,sdf,0.600000\n");
}

TEST_F(PartsTable, HasBothMetricsForBothSplitsAndTheTimes) {
  const auto tables = Tables();
  ASSERT_EQ(tables.size(), 5U);
  EXPECT_THAT(tables[0]["title"], HasSubstr("1 - Rand index"));
  EXPECT_THAT(tables[0]["title"], HasSubstr("3 models that nothing was tuned on"));
  EXPECT_THAT(tables[1]["title"], HasSubstr("5 models"));
  EXPECT_THAT(tables[2]["title"], HasSubstr("Cut discrepancy"));
  EXPECT_EQ(tables[0]["columns"], nlohmann::json({"class", "mirror", "sdf"}));
  EXPECT_EQ(tables[0]["rows"].back(), nlohmann::json({"mean of the classes", 0.4, 0.3}));
}

TEST_F(PartsTable, TimesStandBesideThePublishedOnes) {
  const auto rows = Tables()[4]["rows"];
  // Models 1 to 5 took 1 to 5 seconds: mean and median 3; published 4.2 and 8.0.
  EXPECT_EQ(rows[0], nlohmann::json({"mirror", 5, 4.0, 0, 0, 3.0, 3.0, 5.0, 4.2, 1}));
  EXPECT_EQ(rows[1], nlohmann::json({"sdf", 5, 4.0, 0, 0, 3.0, 3.0, 5.0, 8.0, 3}));
}

TEST_F(PartsTable, WithoutRowsThereAreDashesAndNoNumbers) {
  rows_.clear();
  const std::string text = FormatParts(options_, rows_, TableFormat::kText);
  EXPECT_THAT(text, HasSubstr("-"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST_F(PartsTable, AnExperimentWithOneSplitHasItsTablesOnce) {
  for (auto& one : options_.classes) one.tune.clear();
  EXPECT_EQ(Tables().size(), 3U);
}

TEST_F(PartsTable, ABrokenPublishedTableIsToldWithItsLine) {
  folder_.Write("6.1.csv", "method,average_s\nSDF,8.9\nK-Means,fast\n");
  try {
    FormatParts(options_, rows_, TableFormat::kText);
    FAIL();
  } catch (const core::InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("6.1.csv:3: 'fast'"));
  }
}

TEST_F(PartsTable, MarkdownHasARuleUnderEveryHead) {
  const std::string text = FormatParts(options_, rows_, TableFormat::kMarkdown);
  EXPECT_THAT(text, HasSubstr("| class | mirror | sdf |\n| --- | ---: | ---: |\n"));
  EXPECT_THAT(text, HasSubstr("experiment_hash"));
}

}  // namespace
}  // namespace rangegrasp::report
