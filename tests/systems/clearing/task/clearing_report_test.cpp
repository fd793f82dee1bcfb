#include "clearing/task/clearing_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace rangegrasp::clearing {
namespace {

experiment::Record RecordOf(const std::string& id, Stop stop, const std::vector<ObjectEnd>& ends) {
  Clearing clearing;
  clearing.stop = stop;
  clearing.scans = 3;
  clearing.objects = ends;
  return {{id, "pile", 1, {}, 0}, ResultOf(clearing, "a")};
}

TEST(ReportOf, CountsObjectsOverRunsAlsoOfThoseThatLeaveNoRecord) {
  const std::vector<experiment::Record> records = {
      RecordOf("pile-0000", Stop::kNothingPerceived,
               {{"a", Fate::kDelivered, 1, ""}, {"b", Fate::kDelivered, 2, ""}}),
      RecordOf("pile-0001", Stop::kTriesUsedUp,
               {{"a", Fate::kLeft, 3, "tries_used_up"}, {"b", Fate::kBrought, 1, "dropped"}}),
      {{"pile-0002", "pile", 1, {{"objects", 2}}, 0}, {"timed_out", "", "", "{}", {}}}};
  const auto report = ReportOf({}, records);
  const auto json = nlohmann::json::parse(report.json)["arrangements"];
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["runs"], 3);
  EXPECT_EQ(json[0]["without_record"], 1);
  EXPECT_EQ(json[0]["objects"], 6);  // none of the third run's objects is delivered
  EXPECT_EQ(json[0]["delivered"], 2);
  EXPECT_EQ(json[0]["brought"], 1);
  EXPECT_DOUBLE_EQ(json[0]["delivered_share"], 2.0 / 6.0);
  EXPECT_EQ(json[0]["ends"],
            nlohmann::json({{"cleared", 1}, {"tries_used_up", 1}, {"timed_out", 1}}));
  EXPECT_EQ(json[0]["not_delivered"],
            nlohmann::json({{"left: tries_used_up", 1}, {"brought: dropped", 1}}));
  EXPECT_EQ(json[0]["by_object"][0]["delivered"], 1);
  EXPECT_EQ(json[0]["by_object"][1]["grasps"], 3);
  EXPECT_NE(experiment::TextOf(report.sections[0].grid).find("33.33"), std::string::npos);
}

TEST(ReportOf, ARunWithoutAnyRecordHasNoRates) {
  const auto report =
      ReportOf({}, {{{"pile-0002", "pile", 1, {}, 0}, {"timed_out", "", "", "{}", {}}}});
  EXPECT_TRUE(nlohmann::json::parse(report.json)["arrangements"][0]["delivered_share"].is_null());
}

}  // namespace

}  // namespace rangegrasp::clearing
