#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"
#include "cylinders/task/cylinders_task.h"

namespace rangegrasp::cylinders {
namespace {

using testing::ElementsAre;

experiment::Stamp StampOf(const std::string& shown, const std::string& rows,
                          const std::string& reference) {
  experiment::Stamp stamp;
  stamp.data = {{kShown, shown}, {kRows, rows}, {kNoise, "0.366"}};
  stamp.data[experiment::kReferenceKey] =
      base::ReadFile(RANGEGRASP_SOURCE_DIR "/experiments/reference/" + reference);
  return stamp;
}

experiment::Record RecordOf(int repetition, const std::string& fits,
                            const std::string& source = "perfect") {
  experiment::Record record;
  record.which.params = {{"source", source}, {"row", 0}, {"repetition", repetition}};
  record.result = {"fitted",
                   "fit",
                   "",
                   R"({"points": 4000, "fits": )" + fits + "}",
                   {{"rcf_as_printed 100", 0.5}, {"rcf_as_printed 100 preparation", 0.25}}};
  return record;
}

experiment::Stamp ResolutionStamp() {
  return StampOf("resolution", R"([{"radius_mm": 10.0, "height_mm": 100.0, "points": 4000}])",
                 "4.3_cylinder_resolution.csv");
}

TEST(CylindersReport, MeansStandBesideThePublishedRowAndFailedFitsCount) {
  auto crashed = RecordOf(3, "[]");
  crashed.result.data = "{}";
  const auto report = ComparisonReport(
      ResolutionStamp(),
      {RecordOf(0, R"([{"method": "rcf_as_printed", "iterations": 100, "radius_mm": 9.9,
                        "radius_error_mm": 0.1, "axis_error_deg": 0.02}])"),
       RecordOf(1, R"([{"method": "rcf_as_printed", "iterations": 100, "radius_mm": 10.7,
                        "radius_error_mm": 0.7, "axis_error_deg": 0.04}])"),
       RecordOf(2, R"([{"method": "rcf_as_printed", "iterations": 100, "failed": true}])"),
       crashed});
  ASSERT_EQ(report.sections.size(), 1u);
  // SE of two values: half their difference.
  EXPECT_THAT(report.sections[0].grid.rows,
              ElementsAre(ElementsAre("10 x 100", "4000", "RCF as printed", "10.3000", "0.4000",
                                      "0.3000", "0.260", "0.0300", "0.0100", "0.0320", "0.5000",
                                      "0.2500", "0.32", "2 of 4")));
  EXPECT_EQ(report.files[0].first, "figure_4.13_perfect.svg");
}

// The published row is that of the method in the text, not of ours.
TEST(CylindersReport, PublishedFiguresOfRcfStandBesideRcfAsPrinted) {
  const auto report = ComparisonReport(
      ResolutionStamp(), {RecordOf(0, R"([{"method": "rcf_as_printed", "iterations": 100,
                        "radius_mm": 9.3, "radius_error_mm": 0.7, "axis_error_deg": 0.4},
                       {"method": "rcf", "iterations": 100, "radius_mm": 9.9,
                        "radius_error_mm": 0.1, "axis_error_deg": 0.02}])")});
  const auto& rows = report.sections.at(0).grid.rows;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0][2], "RCF as printed");
  EXPECT_EQ(rows[0][6], "0.260");
  EXPECT_EQ(rows[1][2], "RCF with additions");
  EXPECT_EQ(rows[1][6], "-");
  ASSERT_EQ(report.published.size(), 3u);
  EXPECT_EQ(report.published[0].row, "RCF as printed, 4000 points, radius error");
  EXPECT_EQ(report.published[0].own, 0.7);
}

TEST(CylindersReport, OnlyPerfectImagesStandBesideThePublishedFigures) {
  const std::string fit = R"([{"method": "rcf_as_printed", "iterations": 100, "radius_mm": 9.9,
                              "radius_error_mm": 0.1, "axis_error_deg": 0.02}])";
  const auto report =
      ComparisonReport(ResolutionStamp(), {RecordOf(0, fit, "noisy"), RecordOf(0, fit)});
  const auto& figures = report.published;
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures[0].row, "RCF as printed, 4000 points, radius error");
  EXPECT_EQ(figures[0].published, 0.26);
  EXPECT_EQ(figures[0].own, 0.1);
  EXPECT_EQ(figures[2].own, 0.5);
  ASSERT_EQ(report.sections.size(), 2u);  // perfect, noisy
  EXPECT_EQ(report.sections[0].grid.rows.at(0)[6], "0.260");
  EXPECT_EQ(report.sections[1].grid.rows.at(0)[6], "-");
  const std::string dots = "RCF as printed, published";
  EXPECT_THAT(report.files.at(0).second, testing::HasSubstr(dots));
  EXPECT_THAT(report.files.at(1).second, testing::Not(testing::HasSubstr(dots)));
}

TEST(CylindersReport, IterationsMakeSixFigures) {
  const auto report =
      ComparisonReport(StampOf("iterations",
                               R"([{"radius_mm": 25.75, "height_mm": 173.0, "points": 29953},
                  {"radius_mm": 26.25, "height_mm": 134.0, "points": 34981}])",
                               "4.4_cylinder_synthetic.csv"),
                       {RecordOf(0, R"([{"method": "rcf", "iterations": 50, "radius_mm": 25.0,
                        "radius_error_mm": 0.75, "axis_error_deg": 0.02},
                       {"method": "rcf", "iterations": 100, "radius_mm": 25.75,
                        "radius_error_mm": 0.0, "axis_error_deg": 0.01},
                       {"method": "rcf_as_printed", "iterations": 100, "radius_mm": 26.0,
                        "radius_error_mm": 0.25, "axis_error_deg": 0.5}])")});
  ASSERT_EQ(report.files.size(), 6u);
  EXPECT_THAT(report.files[0].second, testing::HasSubstr("RCF as printed"));
  EXPECT_EQ(report.files[0].first, "figure_4.14_perfect.svg");
  EXPECT_EQ(report.files[5].first, "figure_4.19_perfect.svg");
  // The table shows the values for 100 iterations; the CSV has both.
  ASSERT_EQ(report.sections[0].grid.rows.size(), 2u);
  EXPECT_THAT(report.sections[0].grid.rows[0], testing::Contains("0.568"));
  EXPECT_EQ(report.csv.rows.size(), 3u);
}

// Circles of few triples may be many times too large; they leave the figure.
TEST(CylindersReport, FewTriplesAsPrintedDoNotFlattenTheFigures) {
  const auto published_dot = [](const std::string& error_mm) {
    const auto report = ComparisonReport(
        StampOf("iterations", R"([{"radius_mm": 25.75, "height_mm": 173.0, "points": 29953}])",
                "4.4_cylinder_synthetic.csv"),
        {RecordOf(0, R"([{"method": "rcf_as_printed", "iterations": 1, "radius_mm": 60.0,
                        "radius_error_mm": )" +
                         error_mm + R"(, "axis_error_deg": 20.0},
                       {"method": "rcf_as_printed", "iterations": 100, "radius_mm": 26.0,
                        "radius_error_mm": 0.25, "axis_error_deg": 0.5}])")});
    const std::string& svg = report.files.at(0).second;
    const std::size_t at = svg.find("<circle");
    return at == std::string::npos ? std::string() : svg.substr(at, svg.find("/>", at) - at);
  };
  EXPECT_FALSE(published_dot("34.25").empty());
  EXPECT_EQ(published_dot("34.25"), published_dot("3425.0"));
}

}  // namespace
}  // namespace rangegrasp::cylinders
