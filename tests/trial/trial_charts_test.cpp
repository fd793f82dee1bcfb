#include "trial/trial_charts.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace rangegrasp::trial {
namespace {

using experiment::Chart;
using experiment::Record;

experiment::Stamp StampOf() {
  experiment::Stamp stamp;
  stamp.identity["groups"] = "cup,can";
  stamp.data["title.cup"] = "Cup";
  stamp.data["reference"] = "object,name,detection_rate,grasping_rate\ncup,Cup,90,50\n";
  return stamp;
}

Record RecordOf(const std::string& object, const std::string& outcome, const std::string& data) {
  Record record;
  record.which.group = object;
  record.result.outcome = outcome;
  record.result.data = data;
  return record;
}

const Chart* Find(const std::vector<Chart>& charts, const std::string& title) {
  const auto found = std::find_if(charts.begin(), charts.end(),
                                  [&](const Chart& chart) { return chart.title == title; });
  return found == charts.end() ? nullptr : &*found;
}

TEST(ChartsOf, CountsByObjectPoseGraspFrictionAndSlip) {
  const std::vector<Record> records = {
      RecordOf("cup", "delivered",
               R"({"detected":true,"pose_class":"up","grasp_type":"rim","friction":0.52,
                   "log":{"slip_in_hand_m":0.0005,"tilt_in_hand_rad":0.001}})"),
      RecordOf("cup", "dropped",
               R"({"detected":true,"pose_class":"up","grasp_type":"rim","friction":0.53,
                   "log":{"slip_in_hand_m":0.003,"tilt_in_hand_rad":1.5}})"),
      RecordOf("can", "no_path",
               R"({"detected":true,"pose_class":"side","grasp_type":"","friction":0.61,"log":{}})"),
      RecordOf("can", "not_segmented", R"({"detected":false,"pose_class":"side","friction":0.9})"),
      RecordOf("can", "crashed", "{}")};
  const auto charts = ChartsOf(StampOf(), records);

  const Chart* detection = Find(charts, "Detection rate by object");
  ASSERT_TRUE(detection);
  EXPECT_EQ(detection->labels, (std::vector<std::string>{"Cup", "can"}));
  EXPECT_EQ(detection->series[0].values[1].of, "1 of 3");  // what crashed stays in the denominator
  EXPECT_EQ(detection->series[1].values[0].value, 90.0);
  EXPECT_FALSE(detection->series[1].values[1].value);

  const Chart* pose = Find(charts, "Delivered by resting pose");
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->labels, (std::vector<std::string>{"side", "up"}));
  EXPECT_EQ(pose->series[0].values[0].of, "0 of 1");
  EXPECT_EQ(pose->series[0].values[1].of, "1 of 2");
  // Wilson's interval of 1 of 2 (Wilson 1927): 0.0945 to 0.9055.
  EXPECT_NEAR(pose->series[0].values[1].range->first, 9.45, 0.01);

  const Chart* grasp = Find(charts, "Delivered by kind of grasp");
  ASSERT_TRUE(grasp);
  EXPECT_EQ(grasp->labels, std::vector<std::string>{"rim"});

  const Chart* friction = Find(charts, "Delivered by friction");
  ASSERT_TRUE(friction);
  EXPECT_EQ(friction->labels, (std::vector<std::string>{"0.50", "0.60"}));

  const Chart* slip = Find(charts, "Delivered by slip");
  ASSERT_TRUE(slip);
  EXPECT_EQ(slip->labels, (std::vector<std::string>{"0-1", "2-5"}));
  EXPECT_EQ(slip->series[0].values[0].of, "1 of 1");
  const Chart* tilt = Find(charts, "Delivered by tilt");
  ASSERT_TRUE(tilt);
  EXPECT_EQ(tilt->labels, (std::vector<std::string>{"0-1", "over 45"}));
}

TEST(ChartsOf, LeavesOutWhatNoRecordTells) {
  const auto charts = ChartsOf(StampOf(), {RecordOf("cup", "crashed", "{}")});
  EXPECT_TRUE(Find(charts, "Detection rate by object"));
  EXPECT_FALSE(Find(charts, "Delivered by slip"));
  EXPECT_FALSE(Find(charts, "Delivered by friction"));
}

}  // namespace
}  // namespace rangegrasp::trial
