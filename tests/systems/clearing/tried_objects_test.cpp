#include "clearing/tried_objects.h"

#include <gtest/gtest.h>

namespace rangegrasp::clearing {
namespace {

Samples Range(std::uint32_t first, std::uint32_t count) {
  Samples samples;
  for (std::uint32_t i = 0; i < count; ++i) samples.push_back({0, first + i});
  return samples;
}

base::Pose At(double x_m) { return base::MakePose(Eigen::Matrix3d::Identity(), {x_m, 0.0, 0.0}); }

TEST(SharedSamples, IsTheShareOfThoseThatEitherHas) {
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(0, 10)), 1.0);
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(5, 10)), 5.0 / 15.0);
  EXPECT_DOUBLE_EQ(SharedSamples(Range(0, 10), Range(10, 10)), 0.0);
  EXPECT_DOUBLE_EQ(SharedSamples({{0, 1}, {1, 2}}, {{1, 2}, {0, 2}}), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(SharedSamples({}, {}), 0.0);
}

TEST(TriedObjects, AnObjectIsPassedOverForGoodAfterItsTries) {
  const ClearingOptions options{.tries_per_object = 2};
  TriedObjects tried(options);
  EXPECT_TRUE(tried.MayBeTaken(Range(0, 100)));
  tried.Failed(Range(0, 100), At(0.0));
  EXPECT_EQ(tried.TriesAt(Range(0, 100)), 1);
  EXPECT_TRUE(tried.MayBeTaken(Range(0, 100)));
  tried.Failed(Range(3, 100), At(0.0));  // seen again with a little noise
  EXPECT_EQ(tried.StateOf(Range(0, 100)), Passed::kTriesUsedUp);
  tried.SceneChanged();
  EXPECT_FALSE(tried.MayBeTaken(Range(0, 100)));
  EXPECT_TRUE(tried.MayBeTaken(Range(80, 100)));  // its neighbor
}

TEST(TriedObjects, WhatHasFailedComesAfterTheOthersOrAtOnce) {
  ClearingOptions options;
  TriedObjects tried(options);
  tried.Failed(Range(0, 100), At(0.0));
  options.retry = Retry::kAfterOthers;
  EXPECT_EQ(tried.TurnOf(Range(0, 100)), 1);
  EXPECT_EQ(tried.TurnOf(Range(200, 100)), 0);
  options.retry = Retry::kAtOnce;
  EXPECT_EQ(tried.TurnOf(Range(0, 100)), 0);
  tried.PassOver(Range(0, 100), Passed::kNoGrasp);
  EXPECT_EQ(tried.TurnOf(Range(0, 100)), std::nullopt);
}

TEST(TriedObjects, WhatHasNoGraspIsPassedOverUntilTheSceneChanges) {
  const ClearingOptions options;
  TriedObjects tried(options);
  tried.PassOver(Range(0, 100), Passed::kNoGrasp);
  tried.PassOver(Range(200, 100), Passed::kNoPath);
  EXPECT_EQ(tried.StateOf(Range(0, 100)), Passed::kNoGrasp);
  EXPECT_EQ(tried.StateOf(Range(200, 100)), Passed::kNoPath);
  tried.SceneChanged();
  EXPECT_TRUE(tried.MayBeTaken(Range(0, 100)));
  EXPECT_TRUE(tried.MayBeTaken(Range(200, 100)));
}

TEST(TriedObjects, WhatIsSeenInThePlaceOfATakenObjectIsNew) {
  const ClearingOptions options{.tries_per_object = 1};
  TriedObjects tried(options);
  tried.Failed(Range(0, 100), At(0.0));
  tried.Taken(Range(0, 100));
  EXPECT_TRUE(tried.MayBeTaken(Range(0, 100)));
}

TEST(TriedObjects, GraspsLikeOneThatHasFailedComeLast) {
  const ClearingOptions options{.other_grasp_m = 0.010};
  TriedObjects tried(options);
  tried.Failed(Range(0, 100), At(0.0));
  grasp::Detection detection;
  detection.objects.resize(1);
  detection.objects[0].samples = Range(0, 100);
  for (const double x_m : {0.0, 0.009, 0.030, 0.001, 0.020}) {
    detection.grasps.emplace_back().X_CH = At(x_m);
  }
  tried.PutFailedLast(detection);
  std::vector<double> order;
  for (const auto& g : detection.grasps) order.push_back(g.X_CH.translation().x());
  EXPECT_EQ(order, (std::vector<double>{0.030, 0.020, 0.0, 0.009, 0.001}));

  detection.objects[0].samples = Range(500, 100);  // nothing has failed at another object
  std::swap(detection.grasps[0], detection.grasps[2]);
  tried.PutFailedLast(detection);
  EXPECT_EQ(detection.grasps[0].X_CH.translation().x(), 0.0);
}

}  // namespace
}  // namespace rangegrasp::clearing
