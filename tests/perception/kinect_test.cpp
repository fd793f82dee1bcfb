// Perception of labelled depth-camera clouds with default options.

#include <gtest/gtest.h>

#include "labelled_cloud.h"
#include "perception/perceive.h"
#include "surveys/separation.h"

namespace rangegrasp::perception {
namespace {

/// The separation score of perception on one cloud.
surveys::Separation ScoreOf(const geometry::CloudFile& cloud) {
  base::Rng rng(1);
  const Scene scene = Perceive(cloud.points, Eigen::Vector3d::Zero(), PerceptionOptions{}, rng);
  std::vector<geometry::Points> objects;
  for (const auto& object : scene.objects) {
    objects.push_back(geometry::Select(scene.cloud.points, object.points));
  }
  return surveys::Compare(cloud.labels, surveys::AssignToObjects(cloud.points, objects));
}

TEST(Kinect, SeparatesBoxesThatDoNotTouchAndTakesNoTableForAnObject) {
  if (!std::filesystem::exists(labelled::KinectFolder())) {
    GTEST_SKIP() << "no labelled clouds in " << labelled::KinectFolder();
  }
  constexpr int kLastOfBoxes = 16;
  double overlap = 0.0;
  double points = 0.0;
  for (const int number : labelled::KinectNumbers()) {
    surveys::Separation score;
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

}  // namespace
}  // namespace rangegrasp::perception
