#include "trial/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "error_of.h"
#include "experiment/report.h"
#include "experiment/statistics.h"

namespace rangegrasp::trial {
namespace {

using experiment::Record;

Record TableTrial(const std::string& object, int index, bool detected, const std::string& outcome) {
  Record record;
  record.which.group = object;
  record.which.id = object + "-" + std::to_string(index);
  record.result.outcome = outcome;
  const auto data =
      nlohmann::json{{"detected", true}, {"text", {{"detected", true}, {"outcome", outcome}}}};
  record.result.data = detected ? data.dump() : "{}";
  record.result.seconds = {{"scan", 0.01 * (index + 1)}};
  return record;
}

class TableTest : public testing::Test {
 protected:
  const experiment::Stamp stamp_ = {{{"experiment", "demo"}, {"groups", "box,mug,none"}},
                                    {},
                                    {{"title.box", "Box (cuboid)"},
                                     {"title.mug", "Mug"},
                                     {"title.none", "Never tried"},
                                     {"reference",
                                      "object,name,detection_rate,grasping_rate\n1,Box "
                                      "(cuboid),90,77.77\noverall,,95.00,80.65\n"}}};
  const std::vector<Record> results_ = {
      TableTrial("box", 0, true, "delivered"), TableTrial("box", 1, true, "dropped"),
      TableTrial("box", 2, true, "delivered"), TableTrial("box", 3, false, "not_segmented"),
      TableTrial("mug", 0, true, "delivered"), TableTrial("mug", 1, false, "timed_out")};
};

TEST_F(TableTest, RatesAreAsDefined) {
  const Table table = BuildTable(stamp_, results_);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_DOUBLE_EQ(*table.rows[0].detection.rate, 0.75);
  EXPECT_DOUBLE_EQ(*table.rows[0].grasping.rate, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(*table.rows[0].text_detection.published, 0.9);
  EXPECT_NEAR(*table.rows[0].text_grasping.published, 0.7777, 1e-12);
  EXPECT_FALSE(table.rows[1].text_grasping.published);
  // "Overall" is the mean of the rows that have the rate; "pooled" counts trials.
  EXPECT_DOUBLE_EQ(*table.overall.detection.rate, (0.75 + 0.5) / 2.0);
  EXPECT_DOUBLE_EQ(*table.overall.grasping.rate, (2.0 / 3.0 + 1.0) / 2.0);
  EXPECT_EQ(table.overall.detection.count.k, 4);
  EXPECT_EQ(table.overall.grasping.count.n, 4);
  EXPECT_NEAR(*table.overall.text_grasping.published, 0.8065, 1e-12);
}

TEST_F(TableTest, FiguresAreOfRowsWhosePublishedCountsAreKnown) {
  EXPECT_TRUE(ReportOf(stamp_, results_).published.empty());
  experiment::Stamp stamp = stamp_;
  stamp.data["reference"] =
      "object,name,detection_rate,grasping_rate,trials\n1,Box (cuboid),90,77.77,10\n";
  const auto figures = ReportOf(stamp, results_).published;
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[1].row, "Box (cuboid), grasping");
  EXPECT_NEAR(figures[1].published, 77.77, 1e-9);
  EXPECT_NEAR(figures[1].own.value(), 200.0 / 3.0, 1e-9);
  const auto& counts = std::get<experiment::TrialsEvidence>(figures[1].evidence);
  EXPECT_EQ(counts.own.k, 2);
  EXPECT_EQ(counts.own.n, 3);
  EXPECT_EQ(counts.published.k, 7);
  EXPECT_EQ(counts.published.n, 9);
}

// A pile taken for one object: not detected by our verdict, but grasped by the text's verdict.
TEST_F(TableTest, TheTextsVerdictIsCountedNextToTheStricterOneAndComparedWithThePublished) {
  auto results = results_;
  results[3].result.data =
      R"({"detected":false,"text":{"detected":true,"outcome":"delivered"},"redraw_reasons":{"moves":2}})";
  const Table table = BuildTable(stamp_, results);
  EXPECT_EQ(table.rows[0].detection.count.k, 3);
  EXPECT_EQ(table.rows[0].grasping.count.k, 2);
  EXPECT_EQ(table.rows[0].text_detection.count.k, 4);
  EXPECT_EQ(table.rows[0].text_grasping.count.k, 3);
  EXPECT_EQ(table.rows[0].text_grasping.count.n, 4);
  EXPECT_FALSE(table.rows[0].detection.published);
  EXPECT_EQ(table.redraws, (std::map<std::string, int>{{"moves", 2}}));
  const auto json = nlohmann::json::parse(ReportOf(stamp_, results).json);
  EXPECT_DOUBLE_EQ(json["rows"][0]["text_grasp_rate"].get<double>(), 0.75);
}

TEST_F(TableTest, DeliveriesThatTouchedOtherObjectsAreCounted) {
  auto results = results_;
  results[0].result.data =
      R"({"detected":true,"others_moved":2,"others_left_table":1,"others_brought":1})";
  results[1].result.data = R"({"detected":true,"others_moved":3})";  // dropped: not a delivery
  const Table table = BuildTable(stamp_, results);
  EXPECT_EQ(table.overall.outcomes.at("delivered"), 3);
  EXPECT_EQ(table.moved_others, 1);
  EXPECT_EQ(table.pushed_off, 1);
  EXPECT_EQ(table.brought_others, 1);
}

TEST_F(TableTest, FailuresStayInTheDenominator) {
  const Table table = BuildTable(stamp_, results_);
  EXPECT_EQ(table.rows[1].detection.count.n, 2);
  EXPECT_EQ(table.rows[1].outcomes.at("timed_out"), 1);
}

TEST_F(TableTest, AnObjectWithoutTrialsHasNullRates) {
  const auto json = nlohmann::json::parse(ReportOf(stamp_, results_).json);
  EXPECT_TRUE(json["rows"][2]["detection_rate"].is_null());
  EXPECT_TRUE(json["rows"][2]["grasp_interval"].is_null());
  EXPECT_DOUBLE_EQ(json["rows"][0]["detection_rate"].get<double>(), 0.75);
  EXPECT_DOUBLE_EQ(json["overall"]["pooled_grasp_rate"].get<double>(), 0.75);
  EXPECT_DOUBLE_EQ(json["stage_seconds"]["scan"]["median"].get<double>(), 0.02);
}

// Detection counts all trials (3 of 4), grasping counts detected objects (2 of 3).
TEST_F(TableTest, IntervalsAndFailuresAreThoseOfTheirRow) {
  const auto report = ReportOf(stamp_, results_);
  const auto& box = report.sections[0].grid.rows[0];
  EXPECT_EQ(box[4], experiment::IntervalText(3, 4));
  EXPECT_EQ(box[6], experiment::IntervalText(2, 3));
  EXPECT_EQ(box.back(), "dropped 1, not_segmented 1");
  const auto json = nlohmann::json::parse(report.json);
  const auto [low, high] = experiment::WilsonInterval(2, 3);
  EXPECT_DOUBLE_EQ(json["rows"][0]["grasp_interval"][0].get<double>(), low);
  EXPECT_DOUBLE_EQ(json["rows"][0]["grasp_interval"][1].get<double>(), high);
}

// In every format, the overall row has the interval of the mean of rows that it prints. The
// interval of all trials has its own name.
TEST_F(TableTest, TheOverallIntervalIsOfTheMeanOfRows) {
  const auto [low, high] = experiment::MeanRateInterval({{3, 4}, {1, 2}}).value();
  const auto report = ReportOf(stamp_, results_);
  const auto json = nlohmann::json::parse(report.json)["overall"];
  EXPECT_EQ(json["detection_interval"], (nlohmann::json{low, high}));
  const auto [pooled_low, pooled_high] = experiment::WilsonInterval(4, 6);
  EXPECT_EQ(json["pooled_detection_interval"], (nlohmann::json{pooled_low, pooled_high}));
  EXPECT_EQ(report.sections[0].grid.rows.back()[4], experiment::IntervalText({{low, high}}));
  const auto csv = base::CsvTable::Parse(
      experiment::Format(report, stamp_, experiment::TableFormat::kCsv), "csv");
  EXPECT_NEAR(csv.Number(3, csv.Column("detection_low")), low, 5e-5);
  EXPECT_NEAR(csv.Number(3, csv.Column("detection_high")), high, 5e-5);
}

// Two of three slid, each with its own figures.
TEST_F(TableTest, FailuresHaveTheirMostFrequentReason) {
  auto results = results_;
  const auto add = [&](const std::string& outcome, const std::string& detail) {
    results.push_back(TableTrial("box", 9, true, outcome));
    results.back().result.detail = detail;
  };
  add("not_lifted", "lost without a felt slip; lifted by 0 mm");
  add("not_lifted", "slid out of the hand; lifted by 3 mm");
  add("not_lifted", "slid out of the hand; lifted by 40 mm");
  add("no_path", "no_ik x3, no_carry x1");
  add("invalid_physics", "unrest_s 1.9 > 1.5");
  add("invalid_physics", "penetration_p95_m 0.0011 > 0.001");
  add("invalid_physics", "penetration_p95_m 0.0012 > 0.001");
  add("detector_failed", "ended with code 3 without an answer; stderr: oh no");
  add("crashed", "Traceback (most recent call last): | File x, line 3 | ValueError: bad");
  const auto report = ReportOf(stamp_, results);
  const std::string failures =
      "crashed 1 (1 x ValueError: bad), detector_failed 1 (1 x ended with code 3 without an "
      "answer), dropped 1, invalid_physics 3 (2 x penetration_p95_m 0.0011 > 0.001), no_path 1 "
      "(1 x no_ik), not_lifted 3 (2 x slid out of the hand), not_segmented 1";
  EXPECT_EQ(report.sections[0].grid.rows[0].back(), failures);
  EXPECT_EQ(report.csv.rows[0].back(), failures);
  const auto json = nlohmann::json::parse(report.json);
  EXPECT_EQ(json["rows"][0]["reasons"]["not_lifted"],
            nlohmann::json({{"lost without a felt slip", 1}, {"slid out of the hand", 2}}));
}

// Reasons that differ in their numbers alone are counted together; the first one is printed whole.
TEST_F(TableTest, TheReasonIsPrintedWithTheNumbersOfItsFirstTrial) {
  auto results = results_;
  const auto add = [&](const std::string& object, const std::string& detail) {
    results.push_back(TableTrial(object, 9, false, "detector_failed"));
    results.back().result.detail = detail;
  };
  add("mug", "X_WG must be a 4 x 4 matrix, not of shape (3, 3)");
  add("box", "no answer within 2 s");
  add("box", "no answer within 20 s");
  const auto report = ReportOf(stamp_, results);
  const auto& rows = report.sections[0].grid.rows;
  EXPECT_THAT(rows[0].back(), testing::HasSubstr("(2 x no answer within 2 s)"));
  EXPECT_THAT(rows[1].back(),
              testing::HasSubstr("(1 x X_WG must be a 4 x 4 matrix, not of shape (3, 3))"));
  EXPECT_THAT(rows.back().back(), testing::HasSubstr("(2 x no answer within 2 s)"));
}

// Words in parentheses are printed if they are those of all trials that are counted together.
TEST_F(TableTest, TheReasonIsPrintedToItsEndOrDotsMarkTheCut) {
  auto results = results_;
  const auto add = [&](const std::string& object, const std::string& outcome,
                       const std::string& detail) {
    results.push_back(TableTrial(object, 9, false, outcome));
    results.back().result.detail = detail;
  };
  add("box", "no_path", "approach_blocked (no straight path) x3, no_ik x1");
  add("mug", "no_path", "approach_blocked (the hand and the table) x2");
  add("mug", "no_path", "no_ik x3");
  add("box", "detector_failed", "TypeError: detect() takes 0 arguments");
  add("mug", "detector_failed",
      "RuntimeError: the model gave 3 grasps, 2 of them wider than 85 mm, none below 40 mm");
  const auto report = ReportOf(stamp_, results);
  const auto& rows = report.sections[0].grid.rows;
  const auto contains = [](const std::string& text) { return testing::HasSubstr(text); };
  EXPECT_THAT(rows[0].back(), contains("no_path 1 (1 x approach_blocked (no straight path))"));
  EXPECT_THAT(rows[0].back(), contains("(1 x TypeError: detect() takes 0 arguments)"));
  EXPECT_THAT(rows[1].back(),
              contains("(1 x RuntimeError: the model gave 3 grasps, 2 of them wider than ...)"));
  EXPECT_THAT(rows.back().back(), contains("no_path 3 (2 x approach_blocked)"));
  const auto json = nlohmann::json::parse(report.json);
  EXPECT_EQ(json["rows"][0]["reasons"]["no_path"], nlohmann::json({{"approach_blocked", 1}}));
}

// They are numbers in separate columns, for making figures from them.
TEST_F(TableTest, TheCsvHasIntervalsAndFailures) {
  const auto csv = base::CsvTable::Parse(
      experiment::Format(ReportOf(stamp_, results_), stamp_, experiment::TableFormat::kCsv), "csv");
  const auto [low, high] = experiment::WilsonInterval(2, 3);
  EXPECT_NEAR(csv.Number(0, csv.Column("grasp_low")), low, 5e-5);
  EXPECT_NEAR(csv.Number(0, csv.Column("grasp_high")), high, 5e-5);
  EXPECT_EQ(csv.Cell(0, csv.Column("failures")), "dropped 1, not_segmented 1");
  EXPECT_EQ(csv.Cell(2, csv.Column("detection_low")), "");  // never tried
}

// The published overall rate is a mean over all published rows.
TEST_F(TableTest, ARunOfSomeObjectsIsNotComparedWithTheOverallOfAll) {
  auto some = stamp_;
  some.data["reference"] += "2,Bowl,50,50\n";
  const Table table = BuildTable(some, results_);
  EXPECT_FALSE(table.overall.text_detection.published);
  EXPECT_FALSE(table.overall.text_grasping.published);
  EXPECT_TRUE(table.rows[0].text_detection.published);
}

TEST_F(TableTest, TheAuditsFiguresAreTheLargestOfAllTrials) {
  auto results = results_;
  for (const int i : {0, 1, 2}) {
    const double creep = i == 1 ? 3.0 : 1.0;
    results[static_cast<std::size_t>(i)].result.data =
        nlohmann::json{{"log", {{"audit", {{"creep_m_s", creep}, {"failed", ""}}}}}}.dump();
  }
  const Table table = BuildTable(stamp_, results);
  EXPECT_EQ(table.audit_max, (std::map<std::string, double>{{"creep_m_s", 3.0}}));
}

// Steps within a stage are only in the JSON.
TEST_F(TableTest, TimesArePrintedByStage) {
  auto results = results_;
  for (Record& record : results) record.result.seconds.emplace_back("perceive:normals", 0.5);
  const auto report = ReportOf(stamp_, results);
  EXPECT_NE(report.notes[2].find(" scan "), std::string::npos);
  EXPECT_EQ(report.notes[2].find("normals"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(report.json)["stage_seconds"].contains("perceive:normals"));
}

TEST_F(TableTest, EveryFormatNamesEveryObject) {
  const auto report = ReportOf(stamp_, results_);
  for (const auto format : base::ValuesOf<experiment::TableFormat>()) {
    const std::string text = experiment::Format(report, stamp_, format);
    for (const char* title : {"Box (cuboid)", "Mug", "Never tried"}) {
      EXPECT_NE(text.find(title), std::string::npos) << text;
    }
  }
}

// Fisher's exact test for 5 of 10 where 10 of 10 are published. The probability of at most 5 of one
// sample's 10 among 15 of 20 is C(10,5) C(10,10) / C(20,15) = 252 / 15504.
TEST_F(TableTest, RowsAreComparedWithPublishedCountsByFishersTest) {
  auto stamp = stamp_;
  stamp.identity["groups"] = "box,mug";
  stamp.data["reference"] =
      "object,name,detection_rate,grasping_rate,trials\n1,Box (cuboid),100,100,10\n2,Mug,90,77.77,"
      "10\noverall,,95.00,88.9,\n";
  std::vector<Record> records;
  for (int i = 0; i < 10; ++i) {
    records.push_back(TableTrial("box", i, true, i < 5 ? "delivered" : "dropped"));
    records.push_back(TableTrial("mug", i, true, "delivered"));
  }
  const Table table = BuildTable(stamp, records);
  EXPECT_DOUBLE_EQ(table.p_threshold, 0.025);
  EXPECT_NEAR(*table.rows[0].text_grasping.p_below, 252.0 / 15504.0, 1e-12);
  EXPECT_DOUBLE_EQ(*table.rows[0].text_detection.p_below, 1.0);
  EXPECT_TRUE(IsBelowPublished(table, table.rows[0]));
  // 77.77 % of 9 detected objects is 7.
  EXPECT_EQ(table.rows[1].text_detection.published_count.k, 9);
  EXPECT_EQ(table.rows[1].text_grasping.published_count.k, 7);
  EXPECT_FALSE(IsBelowPublished(table, table.rows[1]));
  // The overall test uses the counts of all rows, 15 of 20 against 17 of 19.
  EXPECT_EQ(table.overall.text_detection.published_count.n, 20);
  EXPECT_DOUBLE_EQ(*table.overall.text_grasping.p_below,
                   experiment::FisherExactLower(15, 20, 17, 19));

  const auto report = ReportOf(stamp, records);
  const auto json = nlohmann::json::parse(report.json);
  EXPECT_TRUE(json["rows"][0]["below_published"].get<bool>());
  EXPECT_FALSE(json["rows"][1]["below_published"].get<bool>());
  EXPECT_EQ(json["rows"][1]["published_delivered"], 7);
  EXPECT_DOUBLE_EQ(json["p_threshold"].get<double>(), 0.025);
  const auto& box = report.sections[0].grid.rows[0];
  EXPECT_EQ(box[box.size() - 2], "0.0163 *");
  EXPECT_NE(report.notes.back().find("Box (cuboid)"), std::string::npos);
}

// The published overall row may state its trials, too. They are those of the rows, once.
TEST_F(TableTest, TrialsOfThePublishedOverallRowAreNotAddedToThoseOfTheRows) {
  auto stamp = stamp_;
  stamp.identity["groups"] = "box,mug";
  stamp.data["reference"] =
      "object,name,detection_rate,grasping_rate,trials\n1,Box (cuboid),40,100,10\n2,Mug,40,100,10\n"
      "overall,,40.00,100.00,20\n";
  const Table table = BuildTable(stamp, results_);
  EXPECT_EQ(table.overall.text_detection.published_count.k, 8);
  EXPECT_EQ(table.overall.text_detection.published_count.n, 20);
  EXPECT_EQ(table.overall.text_grasping.published_count.k, 8);
  EXPECT_EQ(table.overall.text_grasping.published_count.n, 8);
}

// Where the published figure of the overall row is missing, so is its p.
TEST_F(TableTest, ARunOfSomeObjectsHasNoOverallP) {
  auto some = stamp_;
  some.identity["groups"] = "box,mug";
  some.data["reference"] =
      "object,name,detection_rate,grasping_rate,trials\n1,Box (cuboid),100,100,10\n2,Mug,90,77.77,"
      "10\n3,Bowl,50,50,10\noverall,,80.00,75.9,\n";
  const auto report = ReportOf(some, results_);
  const auto& grid = report.sections[0].grid;
  int compared = 0;
  for (std::size_t column = 0; column < grid.header.size(); ++column) {
    if (grid.header[column] != "p") continue;
    ++compared;
    EXPECT_NE(grid.rows[0][column], "-");
    EXPECT_EQ(grid.rows.back()[column], "-");
  }
  EXPECT_EQ(compared, 2);
  EXPECT_FALSE(nlohmann::json::parse(report.json)["overall"].contains("grasp_p_below"));
}

TEST_F(TableTest, OnlyATableWithPublishedFiguresSaysWhatTheyAreComparedWith) {
  const auto notes = [&](const experiment::Stamp& stamp) {
    return base::Join(ReportOf(stamp, results_).notes, "\n");
  };
  EXPECT_NE(notes(stamp_).find("published figures are compared"), std::string::npos);
  auto own = stamp_;
  own.data.erase("reference");
  EXPECT_EQ(notes(own).find("published figures"), std::string::npos);
  EXPECT_NE(notes(own).find("(text): "), std::string::npos);
}

TEST_F(TableTest, WithoutPublishedCountsNothingIsCompared) {
  const auto report = ReportOf(stamp_, results_);
  const auto& header = report.sections[0].grid.header;
  EXPECT_EQ(std::count(header.begin(), header.end(), "p"), 0);
  const auto json = nlohmann::json::parse(report.json);
  EXPECT_FALSE(json.contains("p_threshold"));
  EXPECT_FALSE(json["rows"][0].contains("grasp_p_below"));
}

TEST_F(TableTest, PublishedTrialsMustBeACount) {
  auto stamp = stamp_;
  stamp.data["reference"] = "object,name,detection_rate,grasping_rate,trials\n1,Box,90,20,1.5\n";
  EXPECT_THROW(BuildTable(stamp, {}), base::InputError);
}

TEST_F(TableTest, AReferenceThatIsNoneIsToldWithItsLine) {
  auto stamp = stamp_;
  stamp.data["reference"] = "object,name,detection_rate,grasping_rate\n1,Box,190,20\n";
  EXPECT_EQ(testing_support::ErrorOf([&] { BuildTable(stamp, {}); }),
            "reference table:2: column 'detection_rate': '190' must be a rate from 0 to 100 "
            "per cent");
}

Record RecordOf(const std::string& object, const std::string& outcome, const std::string& data) {
  Record record;
  record.which.group = object;
  record.result.outcome = outcome;
  record.result.data = data;
  return record;
}

using experiment::Chart;

experiment::Stamp StampOf() {
  experiment::Stamp stamp;
  stamp.identity["groups"] = "cup,can";
  stamp.data["title.cup"] = "Cup";
  stamp.data["reference"] = "object,name,detection_rate,grasping_rate\ncup,Cup,90,50\n";
  return stamp;
}

const Chart* Find(const std::vector<Chart>& charts, const std::string& title) {
  const auto found = std::ranges::find(charts, title, &Chart::title);
  return found == charts.end() ? nullptr : &*found;
}

TEST(ChartsOf, CountsByObjectPoseGraspFrictionAndSlip) {
  const std::vector<Record> records = {
      RecordOf("cup", "delivered",
               R"({"detected":true,"pose_class":"up","grasp_type":"rim","friction":0.52,
                   "log":{"slip_in_hand_m":0.0005,"tilt_in_hand_rad":0.001,
                          "grasp":{"probability":0.81}}})"),
      RecordOf("cup", "dropped",
               R"({"detected":true,"pose_class":"up","grasp_type":"rim","friction":0.53,
                   "log":{"slip_in_hand_m":0.003,"tilt_in_hand_rad":1.5,
                          "grasp":{"probability":0.87}}})"),
      RecordOf("can", "no_path",
               R"({"detected":true,"pose_class":"side","grasp_type":"","friction":0.6,"log":{}})"),
      RecordOf("can", "not_segmented", R"({"detected":false,"pose_class":"side","friction":0.9})"),
      RecordOf("can", "crashed", "{}")};
  const auto charts = ChartsOf(StampOf(), records);

  const Chart* detection = Find(charts, "Detection rate by object");
  ASSERT_TRUE(detection);
  EXPECT_EQ(detection->labels, (std::vector<std::string>{"Cup", "can"}));
  EXPECT_EQ(detection->series[0].values[1].of, "1 of 3");  // crashed trials stay in the denominator
  EXPECT_EQ(detection->series[2].values[0].value, 90.0);
  EXPECT_FALSE(detection->series[2].values[1].value);

  const Chart* pose = Find(charts, "Delivered by resting pose");
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->labels, (std::vector<std::string>{"side", "up"}));
  EXPECT_EQ(pose->series[0].values[0].of, "0 of 1");
  EXPECT_EQ(pose->series[0].values[1].of, "1 of 2");
  // Wilson's interval for 1 of 2 (Wilson 1927) is 0.0945 to 0.9055.
  EXPECT_NEAR(pose->series[0].values[1].range->first, 9.45, 0.01);

  const Chart* grasp = Find(charts, "Delivered by kind of grasp");
  ASSERT_TRUE(grasp);
  EXPECT_EQ(grasp->labels, std::vector<std::string>{"rim"});

  const Chart* friction = Find(charts, "Delivered by friction");
  ASSERT_TRUE(friction);
  // 0.6 / 0.05 is slightly below 12.
  EXPECT_EQ(friction->labels, (std::vector<std::string>{"0.50", "0.60"}));

  const Chart* slip = Find(charts, "Delivered by slip");
  ASSERT_TRUE(slip);
  EXPECT_EQ(slip->labels, (std::vector<std::string>{"0-1", "2-5"}));
  EXPECT_EQ(slip->series[0].values[0].of, "1 of 1");
  const Chart* tilt = Find(charts, "Delivered by tilt");
  ASSERT_TRUE(tilt);
  EXPECT_EQ(tilt->labels, (std::vector<std::string>{"0-1", "over 45"}));

  const Chart* predicted = Find(charts, "Delivered by predicted probability");
  ASSERT_TRUE(predicted);
  EXPECT_EQ(predicted->labels, std::vector<std::string>{"80-90"});
  EXPECT_EQ(predicted->series[0].values[0].of, "1 of 2");
  EXPECT_NEAR(*predicted->series[1].values[0].value, 84.0, 1e-9);

  // Which records each figure counts.
  using Positions = std::vector<std::size_t>;
  EXPECT_EQ(detection->series[0].values[1].cases, (Positions{2, 3, 4}));
  EXPECT_EQ(Find(charts, "Grasping rate by object")->series[0].values[1].cases, Positions{2});
  EXPECT_EQ(pose->series[0].values[1].cases, (Positions{0, 1}));
  EXPECT_EQ(friction->series[0].values[1].cases, Positions{2});
  EXPECT_EQ(slip->series[0].values[1].cases, Positions{1});
}

TEST(GridOf, HasPublishedColumnsOnlyWhereSomethingIsPublished) {
  const auto columns_of = [](const experiment::Stamp& stamp) {
    const auto grid = ReportOf(stamp, {RecordOf("cup", "delivered", R"({"detected":true})")})
                          .sections.front()
                          .grid;
    return std::ranges::count(grid.header, "published");
  };
  EXPECT_EQ(columns_of(StampOf()), 2);
  experiment::Stamp own = StampOf();
  own.data.erase("reference");
  EXPECT_EQ(columns_of(own), 0);
}

TEST(ChartsOf, LeavesOutWhatNoRecordTells) {
  const auto charts = ChartsOf(StampOf(), {RecordOf("cup", "crashed", "{}")});
  EXPECT_TRUE(Find(charts, "Detection rate by object"));
  EXPECT_FALSE(Find(charts, "Delivered by slip"));
  EXPECT_FALSE(Find(charts, "Delivered by friction"));
  EXPECT_FALSE(Find(charts, "Delivered by predicted probability"));
}

}  // namespace
}  // namespace rangegrasp::trial
