#include "grasp/detector.h"

#include <gtest/gtest.h>

#include "grasp/fixtures.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;

// Two objects with only every second sample of the observation kept. The detection names the
// observation's samples, not those of the filtered cloud.
TEST(DetectionFrom, NamesTheSamplesOfTheObservation) {
  SceneBuilder builder;
  builder.AddCup(0.041, 0.004, 0.095, At(0.03, -0.02));
  builder.AddBox({0.06, 0.08, 0.1}, At(0.0, 0.2));
  for (std::uint32_t i = 0; i < builder.scene.cloud.size(); ++i) {
    builder.scene.source.push_back(i);
    builder.scene.samples.push_back({(2 * i + 7) % 2, 2 * i + 7});
  }
  builder.scene.objects[1].size_m = {0.08, 0.06, 0.1};
  const Detection detection = DetectionFrom(builder.scene, {});
  ASSERT_EQ(detection.objects.size(), 2u);
  std::uint32_t next = 7;
  for (const DetectedObject& object : detection.objects) {
    for (const geometry::SampleId& sample : object.samples) {
      EXPECT_EQ(sample, (geometry::SampleId{next % 2, next}));
      next += 2;
    }
  }
  EXPECT_EQ(next, 2 * builder.scene.cloud.size() + 7);
  EXPECT_TRUE(detection.objects[0].rotational && detection.objects[0].open);
  EXPECT_FALSE(detection.objects[1].rotational || detection.objects[1].open);
  EXPECT_EQ(detection.objects[1].surface_C.vertices, builder.scene.objects[1].surface_C.vertices);
  EXPECT_EQ(detection.objects[1].center_C, builder.scene.objects[1].center_C);
  EXPECT_EQ(detection.objects[1].size_m, builder.scene.objects[1].size_m);
}

TEST(DetectionFrom, TakesEveryGraspAlongInItsOrder) {
  SceneBuilder builder;
  builder.AddBox({0.115, 0.06, 0.115}, At(0.03, -0.05, 0.4));
  builder.scene.source.resize(builder.scene.cloud.size());
  builder.scene.samples.resize(builder.scene.cloud.size());
  const auto grasps = PlanGrasps(builder.scene, 0, Hand(), ArmBase(), {});
  const Detection detection = DetectionFrom(builder.scene, grasps);
  ASSERT_EQ(detection.grasps.size(), grasps.size());
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    const DetectedGrasp& g = detection.grasps[i];
    EXPECT_EQ(g.object, 0u);
    EXPECT_EQ(g.X_CH.matrix(), grasps[i].X_CH.matrix());
    EXPECT_EQ(g.opening_m, grasps[i].opening_m);
    EXPECT_EQ(g.width_m, grasps[i].width_m);
    EXPECT_EQ(g.score, grasps[i].score);
    EXPECT_EQ(g.type, grasps[i].type);
    EXPECT_EQ(g.pitch_rad, grasps[i].pitch_rad);
    EXPECT_EQ(g.collides, grasps[i].collides);
    // The hand moves down to the box from above.
    EXPECT_NEAR(g.approach_C.norm(), 1.0, 1e-12);
    EXPECT_LT(g.approach_C.z(), -0.7);
  }
}

}  // namespace
}  // namespace rangegrasp::grasp
