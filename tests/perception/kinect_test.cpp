// Perception of labelled clouds of a depth camera, with no option given.

#include <gtest/gtest.h>

#include "labelled_cloud.h"
#include "perception/perceive.h"
#include "separation_score.h"

namespace rangegrasp::perception {
namespace {

/// What perception makes of one cloud, scored.
labelled::Separation ScoreOf(const labelled::Cloud& cloud) {
  base::Rng rng(1);
  const Scene scene =
      Perceive(cloud.file.points, Eigen::Vector3d::Zero(), PerceptionOptions{}, rng);
  std::vector<geometry::Points> objects;
  for (const auto& object : scene.objects) {
    objects.push_back(geometry::Select(scene.cloud.points, object.points));
  }
  return labelled::Compare(cloud.labels, labelled::AssignToObjects(cloud.file.points, objects));
}

TEST(Kinect, SeparatesBoxesThatDoNotTouchAndTakesNoTableForAnObject) {
  if (!std::filesystem::exists(labelled::KinectFolder())) {
    GTEST_SKIP() << "no labelled clouds in " << labelled::KinectFolder();
  }
  constexpr int kLastOfBoxes = 16;
  double overlap = 0.0;
  double points = 0.0;
  for (const int number : labelled::KinectNumbers()) {
    labelled::Separation score;
    ASSERT_NO_THROW(score = ScoreOf(labelled::ReadKinect(number))) << "learn" << number;
    EXPECT_EQ(score.of_table, 0) << "learn" << number;
    if (number > kLastOfBoxes) continue;
    EXPECT_TRUE(score.right) << "learn" << number << " overlap " << score.overlap;
    overlap += score.overlap * score.points;
    points += score.points;
  }
  RecordProperty("weighted_overlap", std::to_string(overlap / points));
  EXPECT_GE(overlap / points, 0.95);
}

// The score of segments that are known: two objects of four points each on a table.
TEST(Separation, IsWhatItsDefinitionSays) {
  const std::vector<std::uint32_t> label = {0, 1, 1, 20, 20, 20, 20, 30, 30, 30, 30};
  const auto exact = labelled::Compare(label, {-1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 1});
  EXPECT_EQ(exact.overlap, 1.0);
  EXPECT_EQ(exact.over, 0.0);
  EXPECT_EQ(exact.under, 0.0);
  EXPECT_EQ(exact.objects, 2);
  EXPECT_TRUE(exact.right);
  const auto joined = labelled::Compare(label, {-1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(joined.overlap, 0.5);
  EXPECT_EQ(joined.under, 0.5);
  EXPECT_FALSE(joined.right);
  const auto split = labelled::Compare(label, {-1, 2, 2, 0, 0, 0, 3, 1, 1, 1, 1});
  EXPECT_EQ(split.overlap, (0.75 + 1.0) / 2);
  EXPECT_EQ(split.over, 0.125);
  EXPECT_EQ(split.of_table, 1);
}

}  // namespace
}  // namespace rangegrasp::perception
