#include "parts/task/parts_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "error_of.h"

namespace rangegrasp::parts {
namespace {

using experiment::Record;
using experiment::Report;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class PartsReportTest : public testing::Test {
 protected:
  PartsReportTest() {
    setup_.classes = {{"cup", {1}, {2, 3}}, {"bird", {4}, {5}}};
    setup_.methods = {Method::kMirror, Method::kSdf};
    setup_.published = "method,average_s\nSDF,8.0\nProposed Method,4.2\nCore Extraction,19.5\n";
    Add("cup", 1, Split::kTune, {0.9, 0.9});
    Add("cup", 2, Split::kReport, {0.1, 0.3});
    Add("cup", 3, Split::kReport, {0.3, 0.5});
    Add("bird", 4, Split::kTune, {0.7, 0.7});
    Add("bird", 5, Split::kReport, {0.6, 0.2});
  }

  // The cut discrepancy is twice the Rand error; the time in seconds equals the id.
  void Add(const std::string& name, int id, Split split, const std::vector<double>& errors) {
    for (std::size_t m = 0; m < errors.size(); ++m) {
      const json data = {
          {"parts", 4}, {"rand_error", errors[m]}, {"cut_discrepancy", 2.0 * errors[m]}};
      experiment::Case which;
      which.id = fmt::format("{}-{}", id, base::Word(setup_.methods[m]));
      which.params = {{"class", name},
                      {"model", id},
                      {"method", std::string(base::Word(setup_.methods[m]))},
                      {"split", std::string(base::Word(split))}};
      records_.push_back({which, {"scored", "score", "", data.dump(), {{"method", id}}}});
    }
  }
  Record& RecordOf(const std::string& id) {
    return *std::find_if(records_.begin(), records_.end(),
                         [&](const Record& one) { return one.which.id == id; });
  }
  void HasNoCut(const std::string& id) {
    json data = json::parse(RecordOf(id).result.data);
    data["cut_discrepancy"] = nullptr;
    RecordOf(id).result.data = data.dump();
  }
  std::vector<MethodMeans> Means(Metric metric, std::optional<Split> split) const {
    std::vector<PartsRow> rows;
    for (const Record& record : records_) rows.push_back(RowOf(record));
    return MeansOf(setup_, rows, metric, split);
  }
  Report Make() const {
    experiment::Stamp stamp;
    stamp.data["parts"] =
        R"({"classes": [{"name": "cup", "tune": [1], "report": [2, 3]},
                        {"name": "bird", "tune": [4], "report": [5]}],
            "methods": ["mirror", "sdf"]})";
    stamp.data["published_table_6.1"] = setup_.published;
    return PartsReport(stamp, records_);
  }
  static std::string FileOf(const Report& report, const std::string& name) {
    for (const auto& [file, text] : report.files) {
      if (file == name) return text;
    }
    return "no such file";
  }

  PartsSetup setup_;
  std::vector<Record> records_;
};

TEST_F(PartsReportTest, MeansOfTheReportSplitLeaveOutWhatWasTunedOn) {
  const auto means = Means(Metric::kRandError, Split::kReport);
  EXPECT_NEAR(means[0].by_class[0].mean.value(), 0.2, 1e-12);
  EXPECT_NEAR(means[1].by_class[0].mean.value(), 0.4, 1e-12);
  EXPECT_NEAR(means[0].by_class[1].mean.value(), 0.6, 1e-12);
  // Mean over classes; the number of models of each class does not matter.
  EXPECT_NEAR(means[0].overall.mean.value(), 0.4, 1e-12);
  EXPECT_NEAR(means[1].overall.mean.value(), 0.3, 1e-12);
  const auto all = Means(Metric::kRandError, std::nullopt);
  EXPECT_NEAR(all[0].by_class[0].mean.value(), 1.3 / 3.0, 1e-12);
}

TEST_F(PartsReportTest, AMeanHasItsStandardErrorOverModelsAndTheirNumber) {
  const auto means = Means(Metric::kRandError, Split::kReport);
  // For 0.1 and 0.3: s = 0.1 sqrt 2, divided by sqrt 2.
  EXPECT_NEAR(means[0].by_class[0].standard_error.value(), 0.1, 1e-12);
  EXPECT_EQ(means[0].by_class[0].count, 2U);
  EXPECT_FALSE(means[0].by_class[1].standard_error);
  // For 0.1, 0.3, 0.6: mean 1/3, sum of squares 0.38 / 3.
  EXPECT_NEAR(means[0].over_models.mean.value(), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(means[0].over_models.standard_error.value(), std::sqrt(0.38 / 3.0 / 2.0 / 3.0),
              1e-12);
  EXPECT_EQ(means[0].over_models.count, 3U);
  const Report report = Make();
  EXPECT_THAT(report.sections[0].title, HasSubstr("3 models without the tuning models"));
  EXPECT_THAT(report.sections[0].grid.rows[0],
              ElementsAre("mirror", "3", "0.3333", "0.1453", "3", "0.6667", "0.2906"));
  EXPECT_THAT(report.sections[1].grid.rows[0][1], "5");
}

// For 0.9, 0.1, 0.3 and for 0.7, 0.6: s^2 = 0.52 / 3 and 0.005, for 3 and 2 models.
TEST_F(PartsReportTest, TheMeanOfTheClassesHasTheErrorOfTheirMeans) {
  const auto means = Means(Metric::kRandError, std::nullopt);
  EXPECT_NEAR(means[0].overall.standard_error.value(), 0.5 * std::sqrt(0.52 / 9.0 + 0.0025), 1e-12);
  EXPECT_FALSE(Means(Metric::kRandError, Split::kReport)[0].overall.standard_error);
}

TEST_F(PartsReportTest, AFailedModelDoesNotCount) {
  experiment::Result& result = RecordOf("3-mirror").result;
  result = {"failed", "read", "off/3.off: no such file", "{}", {}};
  EXPECT_NEAR(Means(Metric::kRandError, Split::kReport)[0].by_class[0].mean.value(), 0.1, 1e-12);
  const Report report = Make();
  EXPECT_EQ(report.sections.back().title, "Failed");
  EXPECT_THAT(report.sections.back().grid.rows[0],
              ElementsAre("cup", "3", "mirror", "off/3.off: no such file"));
}

// However a method ended abnormally, its row counts as failed and gives the reason.
TEST_F(PartsReportTest, WhatCrashedOrTimedOutIsCountedAsFailed) {
  RecordOf("2-sdf").result = {experiment::kCrashed, "", "signal 11", "{}", {}};
  RecordOf("5-sdf").result = {experiment::kTimedOut, "", "", "{}", {}};
  const Report report = Make();
  const auto& times = report.sections[report.sections.size() - 2].grid;
  EXPECT_EQ(times.rows[1][0], "sdf");
  EXPECT_EQ(times.rows[1][1], "3");  // models
  EXPECT_EQ(times.rows[1][3], "2");  // failed
  const auto& failed = report.sections.back().grid.rows;
  ASSERT_EQ(failed.size(), 2U);
  EXPECT_THAT(failed[0], ElementsAre("cup", "2", "sdf", "crashed: signal 11"));
  EXPECT_THAT(failed[1], ElementsAre("bird", "5", "sdf", "timed_out"));
  const auto rows = base::CsvTable::Parse(FileOf(report, "rows.csv"), "rows.csv");
  EXPECT_EQ(rows.rows(), records_.size());
  EXPECT_EQ(rows.Cell(3, rows.Column("failed")), "1");
}

TEST_F(PartsReportTest, AClassWithoutACutHasNoDiscrepancyAndDoesNotCountInTheMean) {
  HasNoCut("2-mirror");
  HasNoCut("3-mirror");
  const auto means = Means(Metric::kCutDiscrepancy, Split::kReport);
  EXPECT_FALSE(means[0].by_class[0].mean);
  EXPECT_NEAR(means[0].overall.mean.value(), 1.2, 1e-12);
  EXPECT_TRUE(means[1].by_class[0].mean);
}

TEST_F(PartsReportTest, HasBothMetricsForBothSplitsAndTheTimes) {
  const auto sections = Make().sections;
  ASSERT_EQ(sections.size(), 7U);
  EXPECT_THAT(sections[2].title, HasSubstr("1 - Rand index"));
  EXPECT_THAT(sections[2].title, HasSubstr("3 models without the tuning models"));
  EXPECT_THAT(sections[3].title, HasSubstr("5 models"));
  EXPECT_THAT(sections[4].title, HasSubstr("Cut discrepancy"));
  // Report split: cups have 0.1 and 0.3; the single bird and the mean of classes have no error.
  EXPECT_THAT(sections[2].grid.rows[0], ElementsAre("cup", "0.2000 +- 0.1000", "0.4000 +- 0.1000"));
  EXPECT_THAT(sections[2].grid.rows[1], ElementsAre("bird", "0.6000", "0.2000"));
  EXPECT_THAT(sections[2].grid.header, ElementsAre("class", "mirror", "sdf"));
  EXPECT_THAT(sections[2].grid.rows.back(), ElementsAre("mean of the classes", "0.4000", "0.3000"));
  EXPECT_TRUE(sections[2].grid.total);
}

TEST_F(PartsReportTest, TimesStandBesideThePublishedOnes) {
  const auto rows = Make().sections[6].grid.rows;
  // Models 1 to 5 took 1 to 5 seconds: the mean is 3; published are 4.2 and 8.0.
  EXPECT_THAT(rows[0], ElementsAre("mirror", "5", "4.0 +- 0.0", "0", "3.0000 +- 0.7071", "4.2"));
  EXPECT_THAT(rows[1], ElementsAre("sdf", "5", "4.0 +- 0.0", "0", "3.0000 +- 0.7071", "8.0"));
}

TEST_F(PartsReportTest, WithoutRecordsThereAreDashesAndNoNumbers) {
  records_.clear();
  const auto sections = Make().sections;
  for (const auto& section : sections) {
    const std::string text = experiment::TextOf(section.grid);
    EXPECT_THAT(text, HasSubstr("-"));
    EXPECT_THAT(text, Not(HasSubstr("nan")));
  }
  EXPECT_THAT(sections.at(2).grid.rows.at(0), ElementsAre("cup", "-", "-"));
}

TEST_F(PartsReportTest, AnExperimentWithOneSplitHasItsTablesOnce) {
  experiment::Stamp stamp;
  stamp.data["parts"] =
      R"({"classes": [{"name": "cup", "tune": [], "report": [2, 3]}], "methods": ["mirror"]})";
  stamp.data["published_table_6.1"] = "";
  EXPECT_EQ(PartsReport(stamp, {}).sections.size(), 4U);
}

TEST_F(PartsReportTest, ABrokenPublishedTableIsToldWithItsLine) {
  setup_.published = "method,average_s\nSDF,8.9\nK-Means,fast\n";
  EXPECT_THAT(testing_support::ErrorOf([&] { Make(); }),
              testing::AllOf(HasSubstr("published table 6.1:3: "), HasSubstr("'fast'")));
}

// Numbers in the rows are read back exactly.
TEST_F(PartsReportTest, TheFilesAreTheRowsAndFigures619To622) {
  json data = json::parse(RecordOf("2-mirror").result.data);
  data["rand_error"] = 1.0 / 3.0;
  RecordOf("2-mirror").result.data = data.dump();
  RecordOf("2-mirror").result.detail = "a \"quoted\", long note";
  const Report report = Make();
  for (const char* metric : {"rand_index", "cut_discrepancy"}) {
    for (const char* split : {"", "_all_models"}) {
      for (const char* ending : {"_by_class.svg", "_overall.svg"}) {
        EXPECT_NE(FileOf(report, std::string(metric) + split + ending), "no such file");
      }
    }
  }
  const auto rows = base::CsvTable::Parse(FileOf(report, "rows.csv"), "rows.csv");
  ASSERT_EQ(rows.rows(), records_.size());
  EXPECT_EQ(rows.Number(2, rows.Column("rand_error")), 1.0 / 3.0);
  EXPECT_EQ(rows.Cell(2, rows.Column("note")), "a \"quoted\", long note");
  EXPECT_EQ(rows.Cell(0, rows.Column("split")), "tune");
}

}  // namespace
}  // namespace rangegrasp::parts
