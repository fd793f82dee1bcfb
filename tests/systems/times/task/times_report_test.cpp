#include "times/task/times_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"

namespace rangegrasp::times {
namespace {

using testing::ElementsAre;

experiment::Stamp StampOf(const std::string& timed, const std::string& reference) {
  experiment::Stamp stamp;
  stamp.data[kTimed] = timed;
  stamp.data[experiment::kReferenceKey] =
      base::ReadFile(std::string(RANGEGRASP_SOURCE_DIR "/experiments/reference/") + reference);
  return stamp;
}

experiment::Record RecordOf(const std::string& group, const std::string& data,
                            const std::vector<std::pair<std::string, double>>& seconds) {
  return {{"scene1-" + group, group, 1, {}, 0}, {"timed", "", "", data, seconds}};
}

TEST(StagesReport, MapsEachOwnStepToOneOfTable51) {
  const auto report =
      ReportOf(StampOf("stages", "5.1_grasp_runtime.csv"), {RecordOf("improved", "{}",
                                                                     {{"sampling", 1},
                                                                      {"table", 2},
                                                                      {"filter", 3},
                                                                      {"smooth", 4},
                                                                      {"normals", 5},
                                                                      {"segments", 6},
                                                                      {"top surfaces", 7},
                                                                      {"merging", 8},
                                                                      {"completion", 9},
                                                                      {"grasp", 10}})});
  const auto& rows = report.sections[0].grid.rows;
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_THAT(rows[0], ElementsAre("plane fit", "1.4", "3.0000"));
  EXPECT_THAT(rows[1], ElementsAre("outlier filter, smoothing", "-", "7.0000"));
  EXPECT_THAT(rows[2], ElementsAre("mesh generation and segmentation", "35.7", "11.0000"));
  EXPECT_THAT(rows[3], ElementsAre("top surface detection", "0.9", "7.0000"));
  EXPECT_THAT(rows[4], ElementsAre("merging rotationally symmetric objects", "2.0", "8.0000"));
  EXPECT_THAT(rows[5], ElementsAre("approximation of 3D objects", "6.0", "9.0000"));
  EXPECT_THAT(rows[6],
              ElementsAre("grasping points and poses, collision detection", "20.0", "10.0000"));
  EXPECT_THAT(rows[7], ElementsAre("sum", "66.0", "55.0000"));
  // The filter is not a step of table 5.1.
  ASSERT_EQ(report.published.size(), 7u);
  EXPECT_EQ(report.published[1].row, "mesh generation and segmentation, method improved");
  EXPECT_DOUBLE_EQ(report.published[1].published, 35.7);
  EXPECT_EQ(report.published[1].own, 11.0);
}

TEST(SegmentationsReport, StandsBesideThePublishedSceneOfTheSameNumber) {
  const std::string data = R"({"scene": 3, "object_points": 28335, "table_points": 55151})";
  const auto report = ReportOf(StampOf("segmentations", "5.8_segmentation_runtime.csv"),
                               {RecordOf("mesh", data, {{"segments", 0.25}, {"table", 9.0}}),
                                RecordOf("region_growing", data, {{"segments", 0.5}})});
  ASSERT_EQ(report.sections[0].grid.rows.size(), 1u);
  EXPECT_THAT(report.sections[0].grid.rows[0],
              ElementsAre("3", "28335", "55151", "0.2500", "30.500", "0.5000", "168.531"));
}

TEST(SegmentationsReport, TakesTheMedianOfTheSeeds) {
  const std::string data = R"({"scene": 3, "object_points": 28335, "table_points": 55151})";
  const auto report = ReportOf(
      StampOf("segmentations", "5.8_segmentation_runtime.csv"),
      {RecordOf("mesh", data, {{"segments", 1.0}}), RecordOf("mesh", data, {{"segments", 3.0}})});
  ASSERT_EQ(report.published.size(), 1u);
  EXPECT_EQ(report.published[0].own, 2.0);
  EXPECT_EQ(std::get<experiment::TimesEvidence>(report.published[0].evidence).measured, 2);
}

}  // namespace
}  // namespace rangegrasp::times
