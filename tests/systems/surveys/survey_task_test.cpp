#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "surveys/separation.h"
#include "surveys/task/measures.h"
#include "temp_folder.h"

namespace rangegrasp::surveys {
namespace {

using nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::ErrorOf;

struct Ran {
  experiment::Record record;
  experiment::Report report;
};

Ran RunOne(const std::string& name, const std::string& object,
           const std::vector<std::string>& set = {}) {
  const auto experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/" + name + ".yaml",
                                 {.set = set, .trials = 1, .groups = {object}});
  experiment.task->Prepare();
  const experiment::Case& which = experiment.cases.front();
  Ran ran{{which, experiment.task->Run(which)}, {}};
  ran.report = experiment.kind->report(experiment.stamp, {ran.record});
  return ran;
}

// The score of known segments: two objects with four points each on a table.
TEST(Separation, IsWhatItsDefinitionSays) {
  const std::vector<std::uint32_t> label = {0, 1, 1, 20, 20, 20, 20, 30, 30, 30, 30};
  const auto exact = Compare(label, {-1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 1});
  EXPECT_EQ(exact.overlap, 1.0);
  EXPECT_EQ(exact.over, 0.0);
  EXPECT_EQ(exact.under, 0.0);
  EXPECT_EQ(exact.objects, 2);
  EXPECT_TRUE(exact.right);
  const auto joined = Compare(label, {-1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(joined.overlap, 0.5);
  EXPECT_EQ(joined.under, 0.5);
  EXPECT_FALSE(joined.right);
  const auto split = Compare(label, {-1, 2, 2, 0, 0, 0, 3, 1, 1, 1, 1});
  EXPECT_EQ(split.overlap, (0.75 + 1.0) / 2);
  EXPECT_EQ(split.over, 0.125);
  EXPECT_EQ(split.of_table, 1);
}

TEST(RotationSurvey, AnUprightTinIsRotationalAboutItsOwnAxis) {
  const auto ran = RunOne("survey_rotation", "salt_cylinder");
  EXPECT_EQ(ran.record.result.outcome, "measured");
  const auto data = ordered_json::parse(ran.record.result.data);
  EXPECT_EQ(data.at("kind"), "rotational");
  EXPECT_LT(data.at("axis_error_rad").get<double>(), 0.05);
  EXPECT_LT(data.at("center_error_m").get<double>(), 0.003);
  const auto& row = ran.report.sections.at(0).grid.rows.at(0);
  EXPECT_EQ(row[0], "salt_cylinder");
  EXPECT_THAT(std::vector(row.begin() + 2, row.begin() + 4), ElementsAre("1", "1"));
}

TEST(RotationSurvey, ABoxIsNotRotational) {
  const auto data = ordered_json::parse(RunOne("survey_rotation", "dextrose").record.result.data);
  EXPECT_NE(data.at("kind"), "rotational");
  EXPECT_FALSE(data.contains("axis_error_rad"));
}

TEST(SeparationSurvey, OneObjectAloneIsOneSegmentForEveryMethod) {
  const auto ran = RunOne("survey_separation", "dextrose", {"arrangement=single"});
  const auto data = ordered_json::parse(ran.record.result.data);
  for (const char* method : {"convexity", "mesh", "lccp", "euclidean"}) {
    EXPECT_EQ(data.at(method).at("objects"), 1) << method;
    EXPECT_GT(data.at(method).at("overlap").get<double>(), 0.9) << method;
  }
  EXPECT_EQ(ran.report.sections.at(0).grid.rows.size(), data.size());
}

TEST(SeparationSurvey, WeighsScansByTheirPoints) {
  const experiment::Record record{{"a", "a", 1, {}, 0}, {"measured", "", "", "", {{"x", 2.0}}}};
  const auto score = [](double overlap, double points, bool right) {
    return ordered_json{{"x",
                         {{"overlap", overlap},
                          {"over", 0.0},
                          {"under", 0.0},
                          {"points", points},
                          {"right", right}}}};
  };
  const auto table =
      SeparationTable({{&record, score(1.0, 300, true)}, {&record, score(0.6, 100, false)}});
  // (300 * 1 + 100 * 0.6) / 400 = 0.9; sqrt(30^2 + 30^2) / 400 = 0.106
  EXPECT_THAT(table.grid.rows.at(0),
              ElementsAre("x", "2", "0.900", "0.106", "0.000", "0.000", "50.0", "9-91", "2.000"));
}

// Two boxes on a table (label 1), seen by a camera 1 m above; z points forward. A corner of the
// second box is not measured.
geometry::CloudFile TwoBoxes() {
  geometry::CloudFile cloud;
  for (int x = 0; x < 120; ++x) {
    for (int y = 0; y < 120; ++y) {
      Eigen::Vector3d p(0.003 * (x - 60), 0.003 * (y - 60), 1.0);
      std::uint32_t label = 1;
      if (std::abs(p.x()) > 0.03 && std::abs(p.x()) < 0.1 && std::abs(p.y()) < 0.05) {
        p.z() = 0.92;
        label = p.x() < 0.0 ? 20 : 30;
      }
      if (label == 30 && p.x() > 0.08 && p.y() > 0.03) {
        p.setConstant(std::nan(""));
        label = 0;
      }
      cloud.points.push_back(p);
      cloud.labels.push_back(label);
    }
  }
  cloud.width = static_cast<int>(cloud.points.size());
  return cloud;
}

TEST(SeparationSurvey, FindsBoxesApartInARecordedCloud) {
  Seconds seconds;
  const auto data = MeasureSeparation(TwoBoxes(), {}, seconds);
  for (const char* method : {"convexity", "mesh", "lccp", "euclidean"}) {
    EXPECT_EQ(data.at(method).at("objects"), 2) << method;
    EXPECT_GT(data.at(method).at("overlap").get<double>(), 0.9) << method;
  }
  EXPECT_EQ(seconds.size(), data.size());
}

TEST(SeparationSurvey, CountsAnObjectOfTwoLabeledPartsAsAWholeToo) {
  auto cloud = TwoBoxes();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.labels[i] == 20 && cloud.points[i].y() > 0.0) cloud.labels[i] = 21;
  }
  Seconds seconds;
  const auto data = MeasureSeparation(cloud, {}, seconds).at("convexity");
  EXPECT_EQ(data.at("objects"), 3);
  EXPECT_FALSE(data.at("right"));
  EXPECT_LT(data.at("overlap").get<double>(), 0.8);  // of one box, half of each part
  EXPECT_TRUE(data.at("whole_right"));
  EXPECT_GT(data.at("whole_overlap").get<double>(), 0.9);
}

TEST(ReconstructionSurvey, MostOfATexturedBoxIsReconstructedWithinMillimetres) {
  const auto ran = RunOne("survey_reconstruction", "dextrose", {"arrangement=single"});
  const auto textured = ordered_json::parse(ran.record.result.data).at("dextrose").at("textured");
  const int made = textured.at("reconstructed");
  EXPECT_GT(made, 0.7 * textured.at("seen").get<int>());
  EXPECT_LT(textured.at("sum_m").get<double>() / made, 0.008);
  int counted = textured.at("mismatches");
  for (const auto& bin : textured.at("errors_0.1mm")) counted += bin[1].get<int>();
  EXPECT_EQ(counted, made);
  EXPECT_EQ(ran.report.sections.at(0).grid.rows.back()[0], "all");
}

TEST(ReconstructionSurvey, TakesQuantilesOfTheErrorsWithMismatchesAsTheLargest) {
  const experiment::Record record{{"a", "a", 1, {}, 0}, {"measured", "", "", "", {}}};
  // Nine errors: -1 mm twice, 0.5 mm six times, one mismatch.
  const ordered_json data = {{"box",
                              {{"plain",
                                {{"seen", 10},
                                 {"reconstructed", 9},
                                 {"mismatches", 1},
                                 {"sum_m", 0.045},
                                 {"errors_0.1mm", {{-10, 2}, {5, 6}}}}}}}};
  const auto table = ReconstructionTable({{&record, data}});
  EXPECT_THAT(table.grid.rows.at(0),
              ElementsAre("box", "all", "10", "90.0", "5.00", "0.5", "-", "0.5", "11.11"));
}

// The error for a folder with one recorded cloud.
std::string ErrorOfClouds(const geometry::CloudFile& cloud,
                          const experiment::Changes& changes = {}) {
  const testing_support::TempFolder folder;
  const auto file =
      folder.Write("survey.yaml", "task: survey\nmeasure: separation\nclouds: recorded\n");
  std::filesystem::create_directory(folder / "recorded");
  geometry::WriteCloud(folder / "recorded/a.pcd",
                       {.profiles = 1,
                        .samples = cloud.width,
                        .points_C = cloud.points,
                        .origins_C = {cloud.sensor_origin.value_or(Eigen::Vector3d::Zero())}},
                       {{"label", cloud.labels}});
  return testing_support::MessageOf([&] { experiment::OpenExperiment(file, changes); });
}

TEST(SeparationSurvey, TakesRecordedCloudsOfACameraThatShowObjects) {
  EXPECT_EQ(ErrorOfClouds(TwoBoxes()), "");
  auto empty = TwoBoxes();
  for (std::uint32_t& label : empty.labels) label = std::min(label, 2U);
  EXPECT_THAT(ErrorOfClouds(empty), HasSubstr("a.pcd: no point has a label of 20 or more"));
  auto in_world = TwoBoxes();
  in_world.sensor_origin = Eigen::Vector3d(0.8, 0.0, 1.6);
  EXPECT_THAT(ErrorOfClouds(in_world), HasSubstr("a.pcd: is not in the camera's frame (z must be "
                                                 "positive): a point has z"));
}

TEST(SeparationSurvey, OfRecordedCloudsHasNoNumberOfTrials) {
  EXPECT_THAT(ErrorOfClouds(TwoBoxes(), {.trials = 2}),
              HasSubstr("--trials: not with `clouds`, each of which is one case"));
}

TEST(SeparationSurvey, OfRecordedCloudsHasNoSceneToShow) {
  const testing_support::TempFolder folder;
  const std::string file =
      folder.Write("survey.yaml", "task: survey\nmeasure: separation\nclouds: recorded\n");
  folder.Write("recorded/a.pcd",
               "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
               "WIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n0 0 1 20\n");
  testing_support::ExpectRefused({"scan", file, "-o", folder / "a.pcd"},
                                 file + ": has no scene that can be shown (`task: survey`)");
}

TEST(ReconstructionSurvey, OfALaserIsRefusedWhenItIsRead) {
  const auto open = [] {
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/survey_rotation.yaml",
                               {.set = {"measure=reconstruction"}});
  };
  EXPECT_THAT(ErrorOf(open), HasSubstr("key 'measure': reconstruction needs a stereo camera as "
                                       "`sensor`, not a line_scanner"));
}

TEST(Survey, RefusesAnUnknownMeasure) {
  EXPECT_THAT(ErrorOf([] { RunOne("survey_rotation", "dextrose", {"measure=size"}); }),
              HasSubstr("separation"));
}

}  // namespace
}  // namespace rangegrasp::surveys
