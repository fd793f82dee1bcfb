#include "report/table.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace rangegrasp::report {
namespace {

using experiment::Outcome;
using experiment::TrialResult;

TrialResult Trial(const std::string& object, int index, bool detected, Outcome outcome) {
  TrialResult result;
  result.object = object;
  result.index = index;
  result.id = object + "-" + std::to_string(index);
  result.detected = detected;
  result.outcome = outcome;
  result.seconds = {{"scan", 0.01 * (index + 1)}};
  return result;
}

class TableTest : public testing::Test {
 protected:
  const std::map<std::string, std::string> stamp_ = {
      {"experiment", "demo"},
      {"objects", "box,mug,none"},
      {"title.box", "Box (cuboid)"},
      {"title.mug", "Mug"},
      {"title.none", "Never tried"},
      {"reference",
       "object,name,detection_rate,grasping_rate\n1,Box "
       "(cuboid),90,77.77\noverall,,95.00,80.65\n"}};
  const std::vector<TrialResult> results_ = {
      Trial("box", 0, true, Outcome::kDelivered), Trial("box", 1, true, Outcome::kDropped),
      Trial("box", 2, true, Outcome::kDelivered), Trial("box", 3, false, Outcome::kNotSegmented),
      Trial("mug", 0, true, Outcome::kDelivered), Trial("mug", 1, false, Outcome::kTimedOut)};
};

TEST_F(TableTest, RatesAreAsDefined) {
  const Table table = BuildTable(stamp_, results_);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_DOUBLE_EQ(*table.rows[0].detection_rate, 0.75);
  EXPECT_DOUBLE_EQ(*table.rows[0].grasp_rate, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(*table.rows[0].published_detection_rate, 0.9);
  EXPECT_NEAR(*table.rows[0].published_grasp_rate, 0.7777, 1e-12);
  EXPECT_FALSE(table.rows[1].published_grasp_rate);
  // Overall is the mean of the rows that have the rate; pooled counts trials.
  EXPECT_DOUBLE_EQ(*table.overall.detection_rate, (0.75 + 0.5) / 2.0);
  EXPECT_DOUBLE_EQ(*table.overall.grasp_rate, (2.0 / 3.0 + 1.0) / 2.0);
  EXPECT_DOUBLE_EQ(*table.pooled_detection_rate, 4.0 / 6.0);
  EXPECT_DOUBLE_EQ(*table.pooled_grasp_rate, 3.0 / 4.0);
  EXPECT_NEAR(*table.overall.published_grasp_rate, 0.8065, 1e-12);
}

TEST_F(TableTest, FailuresStayInTheDenominator) {
  const Table table = BuildTable(stamp_, results_);
  EXPECT_EQ(table.rows[1].trials, 2);
  EXPECT_EQ(table.rows[1].outcomes.at("timed_out"), 1);
}

TEST_F(TableTest, AnObjectWithoutTrialsHasNullRates) {
  const auto json = nlohmann::json::parse(Format(BuildTable(stamp_, results_), TableFormat::kJson));
  EXPECT_TRUE(json["rows"][2]["detection_rate"].is_null());
  EXPECT_TRUE(json["rows"][2]["grasp_interval"].is_null());
  EXPECT_DOUBLE_EQ(json["rows"][0]["detection_rate"].get<double>(), 0.75);
  EXPECT_DOUBLE_EQ(json["overall"]["pooled_grasp_rate"].get<double>(), 0.75);
  EXPECT_DOUBLE_EQ(json["stage_seconds"]["scan"]["median"].get<double>(), 0.02);
}

TEST_F(TableTest, EveryFormatNamesEveryObject) {
  const Table table = BuildTable(stamp_, results_);
  for (const auto format :
       {TableFormat::kText, TableFormat::kMarkdown, TableFormat::kCsv, TableFormat::kJson}) {
    const std::string text = Format(table, format);
    for (const char* title : {"Box (cuboid)", "Mug", "Never tried"}) {
      EXPECT_NE(text.find(title), std::string::npos) << text;
    }
  }
}

TEST_F(TableTest, ComparisonPairsTrialsOfTheSameSeed) {
  auto second = results_;
  second[1].outcome = Outcome::kDelivered;
  second[4].outcome = Outcome::kDropped;
  second[5].seed = 99;  // another trial: not paired
  const Comparison comparison = Compare(results_, second);
  EXPECT_EQ(comparison.pairs, 5);
  EXPECT_EQ(comparison.only_first, 1);
  EXPECT_EQ(comparison.only_second, 1);
  EXPECT_EQ(comparison.both, 2);
  EXPECT_EQ(comparison.same_outcome, 3);
  EXPECT_DOUBLE_EQ(comparison.p_value, 1.0);
}

}  // namespace
}  // namespace rangegrasp::report
