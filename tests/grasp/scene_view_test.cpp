#include "grasp/scene_view.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rangegrasp::draw {
namespace {

// Four table points, one outlier, two objects with two points each, and one point above the table
// that is in no object.
struct Example {
  geometry::Points points_C = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, 0.9}};
  perception::Scene scene;

  Example() {
    scene.table.points = {0, 1, 2, 3};
    scene.outliers = {4};
    scene.cloud.points = {
        {0, 0, 0.1}, {0, 0.1, 0.1}, {0.3, 0, 0.1}, {0.3, 0.1, 0.1}, {0.2, 0, 0.1}};
    scene.objects.resize(2);
    scene.objects[0].points = {0, 1};
    scene.objects[1].points = {2, 3};
  }
};

TEST(DrawScene, DrawsEveryPointOnce) {
  const Example example;
  const Canvas canvas = DrawScene(example.points_C, example.scene, {}, {});
  std::size_t dots = 0;
  for (const auto& group : canvas.dots) dots += group.points.size();
  EXPECT_EQ(dots, 4u + 1u + 5u);
  EXPECT_TRUE(canvas.surfaces.empty());
}

TEST(DrawScene, DrawsTheRimAsAClosedLine) {
  Example example;
  example.scene.objects[0].top.emplace();
  example.scene.objects[0].top->rim = {0, 1, 4};
  const Canvas canvas = DrawScene(example.points_C, example.scene, {}, {});
  ASSERT_EQ(canvas.lines.size(), 1u);
  ASSERT_EQ(canvas.lines[0].points.size(), 4u);
  EXPECT_EQ(canvas.lines[0].points.front(), canvas.lines[0].points.back());
}

TEST(DrawScene, DrawsAHandForFreeGraspsAlone) {
  const Example example;
  robot::HandModel hand;
  hand.states.resize(1);
  grasp::Grasp grasp;
  grasp.collides = true;
  EXPECT_TRUE(DrawScene(example.points_C, example.scene, {{grasp}, {}}, hand).surfaces.empty());
  grasp.collides = false;
  EXPECT_EQ(DrawScene(example.points_C, example.scene, {{}, {grasp}}, hand).surfaces.size(), 1u);
}

TEST(LookAtScene, HasTheWholeSceneInView) {
  const Example example;
  const View view = LookAtScene(example.scene, {2.0, 0.0, 1.5});
  const Eigen::Vector3d ahead = (view.target - view.eye).normalized();
  for (const auto& p : example.scene.cloud.points) {
    const double angle = std::acos((p - view.eye).normalized().dot(ahead));
    EXPECT_LT(angle, 0.5 * view.field_of_view_rad);
  }
  EXPECT_GT(view.eye.z(), 0.0);
}

TEST(LookAtScene, AnEmptySceneStillGivesAFiniteView) {
  const View view = LookAtScene({}, {2.0, 0.0, 1.5});
  EXPECT_TRUE(view.eye.allFinite());
  EXPECT_GT((view.eye - view.target).norm(), 0.1);
}

}  // namespace
}  // namespace rangegrasp::draw
