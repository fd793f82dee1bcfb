#include "parts/task/parts_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "experiment/view.h"
#include "parts/method.h"
#include "parts/metrics/human_score.h"
#include "parts/task/peanuts.h"

namespace rangegrasp::parts {
namespace {

using experiment::Case;
using experiment::Result;
using nlohmann::json;
using testing::HasSubstr;
using testing_support::Peanuts;

class PartsTaskTest : public testing::Test {
 protected:
  Case CaseOf(const std::string& id) const {
    const auto cases = task_->Cases();
    return *std::find_if(cases.begin(), cases.end(), [&](const Case& one) { return one.id == id; });
  }
  Result Run(const std::string& id) const { return task_->Run(CaseOf(id)); }

  Peanuts peanuts_;
  std::unique_ptr<experiment::Task> task_ = peanuts_.Read(Peanuts::kGood);
};

TEST_F(PartsTaskTest, ACaseIsOneMethodOnOneModelInTheOrderOfTheFile) {
  std::vector<std::string> ids, groups;
  for (const Case& one : task_->Cases()) {
    ids.push_back(one.id);
    groups.push_back(one.group);
    EXPECT_EQ(one.seed, 0U);
  }
  EXPECT_THAT(ids,
              testing::ElementsAre("peanut-0001-kmeans", "peanut-0001-sdf", "peanut-0002-kmeans",
                                   "peanut-0002-sdf", "peanut-0003-kmeans", "peanut-0003-sdf",
                                   "other-0011-kmeans", "other-0011-sdf"));
  EXPECT_EQ(groups.front(), "peanut");
  EXPECT_EQ(groups.back(), "other");
  EXPECT_EQ(ToJson(task_->Cases()[1].params),
            R"({"class":"peanut","method":"sdf","model":1,"split":"tune"})");
  EXPECT_FALSE(PartsTask().uses_seed);
}

TEST_F(PartsTaskTest, ACaseIsScoredAgainstItsHumansAndAlwaysTheSame) {
  for (const Case& which : task_->Cases()) {
    const Result result = task_->Run(which);
    ASSERT_EQ(result.outcome, "scored") << result.detail;
    const json data = json::parse(result.data);
    EXPECT_GT(data.at("parts"), 0);
    ASSERT_EQ(result.seconds.size(), 1U);
    EXPECT_EQ(result.seconds[0].first, "method");
    EXPECT_GE(result.seconds[0].second, 0.0);
    const Result again = task_->Run(which);
    EXPECT_EQ(again.data, result.data);
    EXPECT_EQ(again.detail, result.detail);
  }
}

// Each model is segmented as a mesh and as each grade of cloud, scored on the same faces.
TEST_F(PartsTaskTest, CloudsOfEveryGradeStandBesideTheirMesh) {
  const std::string text =
      "data: .\nmethods: [mirror, hierarchy]\nclasses: [peanut]\n"
      "clouds: {points: [2000, 4000], noise_percent: [0, 0.25]}\n"
      "models:\n  peanut: {tune: [1], report: [2]}\n";
  task_ = peanuts_.Read(text);
  const auto cases = task_->Cases();
  ASSERT_EQ(cases.size(), 2U * 2U * (1U + 4U));
  EXPECT_EQ(cases[2].id, "peanut-0001-mirror-2000-0.25");
  for (const char* id : {"peanut-0002-hierarchy-4000-0", "peanut-0002-hierarchy-4000-0.25"}) {
    const Result result = Run(id);
    ASSERT_EQ(result.outcome, "scored") << result.detail;
    EXPECT_EQ(result.data, Run(id).data);
    // A peanut's halves are its parts, whatever is found for its mesh of few faces. The stripe adds
    // to the error of the mean over people.
    EXPECT_LT(json::parse(result.data).at("rand_error").get<double>(), 0.35);
  }
  std::string broken = text;
  broken.replace(broken.find("mirror,"), 7, "sdf,");
  EXPECT_THROW(peanuts_.Read(broken), base::InputError);
  broken = text;
  broken.replace(broken.find("0.25"), 4, "99");
  EXPECT_THROW(peanuts_.Read(broken), base::InputError);
}

// The numbers in a record are bit-identical to the computed doubles.
TEST_F(PartsTaskTest, FiguresAreReadBackAsTheyWereFound) {
  const auto model = ReadHumanModel(peanuts_.folder.path(), 3);
  const auto found = SegmentBy(Method::kSdf, model.shape, {});
  const auto score = ScoreAgainstHumans(model, found);
  const json data = json::parse(Run("peanut-0003-sdf").data);
  EXPECT_EQ(data.at("rand_error").get<double>(), score.rand_error);
  ASSERT_EQ(data.at("cut_discrepancy").is_null(), !score.cut_discrepancy);
  if (score.cut_discrepancy) {
    EXPECT_EQ(data.at("cut_discrepancy").get<double>(), *score.cut_discrepancy);
  }
}

TEST_F(PartsTaskTest, KMeansTakesTheMeanNumberOfHumanSegments) {
  // Two and three segments: 2.5, rounded up.
  EXPECT_EQ(MeanHumanSegments(peanuts_.folder.path(), std::vector{1, 2, 3}), 3);
  for (const Case& which : task_->Cases()) {
    if (!which.id.ends_with("kmeans")) continue;
    EXPECT_EQ(json::parse(task_->Run(which).data).at("parts"), 3);
  }
}

TEST_F(PartsTaskTest, AModelThatFailsSaysWhyAndTheOthersGoOn) {
  peanuts_.folder.Write("off/2.off", "OFF\nrubbish\n");
  std::filesystem::remove_all(peanuts_.folder / "seg/3");
  peanuts_.folder.Write("seg/11/11_3.seg", "0\n1\n");
  task_ = peanuts_.Read(Peanuts::kGood);
  for (const Case& which : task_->Cases()) {
    const Result result = task_->Run(which);
    const bool works = which.id.starts_with("peanut-0001");
    EXPECT_EQ(result.outcome, works ? "scored" : experiment::kCrashed) << which.id;
    if (works) continue;
    EXPECT_EQ(result.data, "{}");
    EXPECT_EQ(result.stage, "read");
    EXPECT_TRUE(result.seconds.empty());
    EXPECT_EQ(result.detail.find('\n'), std::string::npos);
  }
  EXPECT_THAT(Run("peanut-0002-sdf").detail, HasSubstr("2.off"));
  EXPECT_THAT(Run("peanut-0003-sdf").detail, HasSubstr("contains no human segmentation 3_<k>.seg"));
  EXPECT_THAT(Run("other-0011-sdf").detail, HasSubstr("11_3.seg:3: has 2 labels"));
}

TEST_F(PartsTaskTest, AReplayLeavesLabelsColoursAndAPicture) {
  const auto folder = peanuts_.folder / "replay";
  const Case which = CaseOf("peanut-0002-kmeans");
  const Result result = task_->Replay(which, {.folder = folder, .video = {}, .camera = {}});
  EXPECT_EQ(result.data, Run("peanut-0002-kmeans").data);
  const auto labels = ReadLabels(folder / "peanut-0002-kmeans.seg");
  EXPECT_EQ(labels.size(), ReadPolygons(peanuts_.folder / "off/2.off").mesh.triangles.size());
  EXPECT_THAT(base::ReadFile(folder / "peanut-0002-kmeans.ply"), testing::StartsWith("ply\n"));
  EXPECT_THAT(base::ReadFile(folder / "peanut-0002-kmeans.png"), testing::StartsWith("\x89PNG"));
}

// The view of a case shows its method first and then every person, whatever folder there is.
TEST_F(PartsTaskTest, AViewStandsBesideThoseOfPeople) {
  experiment::View view;
  experiment::ReplayOptions options;
  options.view = &view;
  const Case which = CaseOf("peanut-0002-kmeans");
  EXPECT_EQ(task_->Replay(which, options).data, Run(which.id).data);
  const auto input = ReadPolygons(peanuts_.folder / "off/2.off").mesh;
  ASSERT_EQ(view.painted.size(), 3U);
  EXPECT_EQ(view.painted[0].layer, "kmeans: 3 parts");
  EXPECT_EQ(view.painted[1].layer, "person 1: 2 parts");
  EXPECT_EQ(view.painted[2].layer, "person 2: 3 parts");
  for (const auto& one : view.painted) {
    EXPECT_EQ(one.mesh_W.triangles, input.triangles);
    ASSERT_EQ(one.paint.size(), input.triangles.size());
    for (const auto color : one.paint) ASSERT_LT(color, one.colors.size());
    for (const auto& p : one.mesh_W.vertices) EXPECT_LE(p.cwiseAbs().maxCoeff(), 0.5 + 1e-12);
  }
}

TEST_F(PartsTaskTest, AModelThatCannotBeReadHasNoView) {
  peanuts_.folder.Write("off/2.off", "OFF\nrubbish\n");
  experiment::View view;
  experiment::ReplayOptions options;
  options.view = &view;
  EXPECT_EQ(task_->Replay(CaseOf("peanut-0002-sdf"), options).outcome, experiment::kCrashed);
  EXPECT_TRUE(view.Empty());
}

TEST(MatchedLabels, AreThoseOfTheOtherWithWhichMostFacesAreShared) {
  // The same parts with other labels.
  EXPECT_EQ(MatchedLabels({5, 5, 0, 0, 0, 9}, {1, 1, 2, 2, 2, 0}), (Labels{1, 1, 2, 2, 2, 0}));
  // Two parts where the other has one: the larger takes its label, the smaller a new one.
  EXPECT_EQ(MatchedLabels({0, 1, 1, 1, 2}, {3, 3, 3, 3, 7}), (Labels{8, 3, 3, 3, 7}));
  // One part where the other has two.
  EXPECT_EQ(MatchedLabels({4, 4, 4}, {0, 1, 1}), (Labels{1, 1, 1}));
  EXPECT_TRUE(MatchedLabels({}, {}).empty());
}

TEST_F(PartsTaskTest, AReplayHasNoVideo) {
  const Case which = CaseOf("peanut-0002-kmeans");
  EXPECT_THROW(
      task_->Replay(which, {.folder = peanuts_.folder.path(), .video = "a.mp4", .camera = {}}),
      base::InputError);
}

TEST_F(PartsTaskTest, AReplayThatCannotBeWrittenIsNoResultOfTheMethod) {
  peanuts_.folder.Write("file", "");
  const Case which = CaseOf("peanut-0002-kmeans");
  EXPECT_THROW(
      task_->Replay(which, {.folder = peanuts_.folder / "file", .video = {}, .camera = {}}),
      base::InputError);
}

}  // namespace
}  // namespace rangegrasp::parts
