#include "grasp/features.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "grasp/fixtures.h"
#include "grasp/proposals.h"
#include "grasp/score_model.h"
#include "temp_folder.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;
using Eigen::Vector3d;

using Boxes = std::vector<Eigen::AlignedBox3d>;

// Ray parameter of the first box hit; at most 1, the end of the ray.
double FirstHit(const Vector3d& from, const Vector3d& to, const Boxes& boxes) {
  double first = 1.0;
  for (const auto& box : boxes) {
    double enters = 0.0, leaves = 1.0;
    for (int k = 0; k < 3; ++k) {
      const double way = to(k) - from(k);
      const double a = (box.min()(k) - from(k)) / way, b = (box.max()(k) - from(k)) / way;
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    if (enters < leaves) first = std::min(first, enters);
  }
  return first;
}

// A sensor on the +x side looks at boxes on the table.
geometry::Observation LookAt(const Boxes& boxes) {
  const Vector3d sensor(0.7, 0.0, 0.5);
  geometry::RangeImage image;
  image.profiles = 175;
  image.samples = 150;
  image.origins_C = {sensor};
  for (int i = 0; i < image.profiles; ++i) {
    for (int j = 0; j < image.samples; ++j) {
      const Vector3d on_table(-0.4 + 0.004 * i + 1e-5, -0.3 + 0.004 * j + 1e-5, 0.0);
      image.points_C.push_back(sensor + FirstHit(sensor, on_table, boxes) * (on_table - sensor));
    }
  }
  geometry::Observation observation = geometry::ObservationOf(std::move(image));
  observation.views.front().X_CV.translation() = sensor;
  return observation;
}

Vector3d NormalOf(const Eigen::AlignedBox3d& box, const Vector3d& p) {
  const Vector3d relative = (p - box.center()).cwiseQuotient(box.sizes());
  Eigen::Index axis = 0;
  relative.cwiseAbs().maxCoeff(&axis);
  return Vector3d::Unit(axis) * (relative(axis) > 0.0 ? 1.0 : -1.0);
}

// The boxes as objects with their seen points.
perception::Scene SceneOf(const geometry::Observation& observation, const Boxes& boxes) {
  perception::Scene scene;
  scene.table.plane.normal = Vector3d::UnitZ();
  for (const auto& box : boxes) {
    perception::PerceivedObject object;
    for (const Vector3d& p : observation.views.front().image.points_C) {
      if (p.z() < 0.004 || box.exteriorDistance(p) > 1e-6) continue;
      object.points.push_back(static_cast<std::uint32_t>(scene.cloud.points.size()));
      scene.cloud.points.push_back(p);
      scene.cloud.normals.push_back(NormalOf(box, p));
    }
    object.center_C = box.center();
    object.size_m = box.sizes();
    object.height_m = box.max().z();
    scene.objects.push_back(object);
  }
  return scene;
}

Eigen::AlignedBox3d BoxAt(double x, double y, const Vector3d& size) {
  return {Vector3d(x - size.x() / 2, y - size.y() / 2, 0.0),
          Vector3d(x + size.x() / 2, y + size.y() / 2, size.z())};
}

// A grasp from above that closes along a level direction, with the pads 25 mm below the top.
Grasp GraspOf(const Eigen::AlignedBox3d& box, const Vector3d& closing, double width_m) {
  Eigen::Matrix3d R;
  R << closing, Vector3d(-Vector3d::UnitZ()).cross(closing), -Vector3d::UnitZ();
  Vector3d at = box.center();
  at.z() = box.max().z() - 0.025;
  return PlaceHand({base::MakePose(R, at), width_m}, Hand(), {});
}

/// @param wall  index of the box that is a container's wall
std::map<std::string_view, double> NamedFeatures(const Boxes& boxes, const Vector3d& closing,
                                                 double width_m,
                                                 std::optional<std::size_t> wall = {}) {
  const auto observation = LookAt(boxes);
  auto scene = SceneOf(observation, boxes);
  if (wall) scene.container = scene.objects[*wall].points;
  const auto values = FeaturesOf(observation, scene, 0, Hand(),
                                 std::array{GraspOf(boxes.front(), closing, width_m)})
                          .front();
  std::map<std::string_view, double> named;
  EXPECT_EQ(values.size(), FeatureNames().size());
  for (std::size_t i = 0; i < values.size(); ++i) named[FeatureNames()[i]] = values[i];
  EXPECT_EQ(named.size(), values.size()) << "names differ";
  return named;
}

const Vector3d kBox(0.05, 0.06, 0.10);

TEST(GraspFeatures, SpaceBehindAnObjectIsUnseenAndBeforeItFree) {
  // The thumb, at +x, is on the sensor's side.
  const auto f = NamedFeatures({BoxAt(0.0, 0.0, kBox)}, Vector3d::UnitX(), 0.05);
  EXPECT_GT(f.at("thumb_beyond_free"), 0.9);
  EXPECT_LT(f.at("thumb_beyond_unseen"), 0.1);
  EXPECT_LT(f.at("thumb_beyond_missing_m"), 0.006);
  EXPECT_GT(f.at("fingers_beyond_unseen"), 0.5);
  EXPECT_GT(f.at("fingers_beyond_unseen_m"), 0.02);
  EXPECT_GT(f.at("thumb_way_free"), f.at("fingers_way_free"));
  const auto turned = NamedFeatures({BoxAt(0.0, 0.0, kBox)}, -Vector3d::UnitX(), 0.05);
  // A mirrored hand does not occupy the same cells.
  EXPECT_NEAR(turned.at("fingers_beyond_free"), f.at("thumb_beyond_free"), 0.25);
  EXPECT_NEAR(turned.at("thumb_beyond_unseen"), f.at("fingers_beyond_unseen"), 0.25);
}

TEST(GraspFeatures, AnObjectMayBeMetresLarge) {
  const Boxes boxes = {BoxAt(0.0, 0.0, kBox)};
  const auto observation = LookAt(boxes);
  auto scene = SceneOf(observation, boxes);
  scene.objects.front().completed_C = {Vector3d(-3.0, -3.0, 0.0), Vector3d(3.0, 3.0, 3.0)};
  const auto values = FeaturesOf(observation, scene, 0, Hand(),
                                 std::array{GraspOf(boxes.front(), Vector3d::UnitX(), 0.05)})
                          .front();
  for (const double value : values) EXPECT_TRUE(std::isfinite(value));
}

TEST(GraspFeatures, BothSidesAreFreeAcrossTheLineOfSight) {
  const auto f = NamedFeatures({BoxAt(0.0, 0.0, kBox)}, Vector3d::UnitY(), 0.06);
  EXPECT_GT(f.at("thumb_beyond_free"), 0.8);
  EXPECT_GT(f.at("fingers_beyond_free"), 0.8);
  EXPECT_EQ(f.at("adjacent"), 0.0);
  EXPECT_EQ(f.at("thumb_neighbor_m"), 0.05) << "none";
}

TEST(GraspFeatures, ANeighborStandsInTheWayOfItsSide) {
  const Boxes boxes{BoxAt(0.0, 0.0, kBox), BoxAt(0.0, 0.07, {0.06, 0.06, 0.12})};
  const auto f = NamedFeatures(boxes, Vector3d::UnitY(), 0.06);
  EXPECT_EQ(f.at("thumb_beyond_free"), 0.0);
  EXPECT_GT(f.at("fingers_beyond_free"), 0.8);
  EXPECT_LT(f.at("thumb_neighbor_m"), 0.02);
  EXPECT_GT(f.at("fingers_neighbor_m"), 0.04);
  EXPECT_GT(f.at("adjacent"), 0.0);
}

TEST(GraspFeatures, WhatStandsBeforeTheObjectHidesIt) {
  const Boxes boxes{BoxAt(-0.05, 0.0, kBox), BoxAt(0.03, 0.0, {0.03, 0.12, 0.12})};
  const auto f = NamedFeatures(boxes, Vector3d::UnitY(), 0.06);
  const auto alone = NamedFeatures({boxes.front()}, Vector3d::UnitY(), 0.06);
  EXPECT_GT(f.at("thumb_beyond_unseen"), alone.at("thumb_beyond_unseen") + 0.3);
  EXPECT_LT(f.at("between_own"), alone.at("between_own") + 1e-9);
  EXPECT_LT(f.at("points"), alone.at("points"));
}

TEST(GraspFeatures, TheSurfaceUnderAPadIsKnownWhereItWasMeasured) {
  // The thumb's face points to the sensor. The fingers' face was not seen; the top's edge is next.
  const auto f = NamedFeatures({BoxAt(0.0, 0.0, kBox)}, Vector3d::UnitX(), 0.05);
  EXPECT_LT(f.at("thumb_seen_m"), 0.006);
  EXPECT_NEAR(f.at("thumb_face"), 1.0, 0.01);
  EXPECT_NEAR(f.at("thumb_up"), 0.0, 1e-9);
  EXPECT_NEAR(f.at("fingers_seen_m"), 0.025, 0.008);
  EXPECT_EQ(f.at("fingers_face"), 0.0);
}

TEST(GraspFeatures, TheLongestAxisIsThatOfWhatWasMeasured) {
  const auto lying = NamedFeatures({BoxAt(0.0, 0.0, {0.04, 0.16, 0.05})}, Vector3d::UnitX(), 0.04);
  EXPECT_LT(lying.at("axis_up"), 0.1);
  const auto upright =
      NamedFeatures({BoxAt(0.0, 0.0, {0.04, 0.05, 0.18})}, Vector3d::UnitX(), 0.04);
  EXPECT_GT(upright.at("axis_up"), 0.9);
}

TEST(GraspFeatures, WallsOfAContainerAreKnownAsWalls) {
  const Boxes boxes{BoxAt(0.0, 0.0, kBox), BoxAt(0.0, 0.045, {0.3, 0.02, 0.12})};
  const auto f = NamedFeatures(boxes, Vector3d::UnitX(), 0.05, 1);
  EXPECT_LT(f.at("hand_wall_m"), 0.03);
  const auto thing = NamedFeatures(boxes, Vector3d::UnitX(), 0.05);
  EXPECT_EQ(thing.at("hand_wall_m"), 0.05) << "none";
  EXPECT_GT(f.at("adjacent"), 0.0);
  EXPECT_EQ(thing.at("adjacent"), f.at("adjacent"));
}

TEST(GraspFeatures, AMovedSceneHasTheSameFeatures) {
  const auto f = NamedFeatures({BoxAt(0.0, 0.0, kBox)}, Vector3d::UnitY(), 0.06);
  for (const double y : {-0.012, 0.012}) {
    const auto moved = NamedFeatures({BoxAt(0.0, y, kBox)}, Vector3d::UnitY(), 0.06);
    for (const auto& [name, value] : f) {
      if (name == "workspace_distance") continue;
      // Shares change by a few of a hundred cells, lengths by part of the samples' spacing.
      const double tolerance = name == "points" ? 0.2 : name.ends_with("_m") ? 0.003 : 0.12;
      EXPECT_NEAR(moved.at(name), value, tolerance) << name;
    }
  }
}

// Grasps up to 45 mm wide have the logit 1, others -1.
ScoreModel ModelForNarrowGrasps() {
  const testing_support::TempFolder files;
  return ScoreModel(files.Write(
      "m.json",
      R"({"features": ["width"], "base": 0.0, "trees": [[[0, 0.045, 1, 2], [1.0], [-1.0]]]})"));
}

TEST(ScoreModelRank, PutsFreeGraspsFirstAndTheMostProbableFirst) {
  const ScoreModel model = ModelForNarrowGrasps();
  const Boxes boxes{BoxAt(0.0, 0.0, kBox)};
  const auto observation = LookAt(boxes);
  std::vector<Grasp> grasps;
  for (const double width_m : {0.03, 0.05, 0.04}) {
    grasps.push_back(GraspOf(boxes.front(), Vector3d::UnitY(), width_m));
  }
  grasps.front().collides = true;
  model.Rank(observation, SceneOf(observation, boxes), 0, Hand(), grasps);
  ASSERT_EQ(grasps.size(), 3u);
  EXPECT_EQ(grasps[0].width_m, 0.04);
  EXPECT_EQ(grasps[1].width_m, 0.05);
  EXPECT_TRUE(grasps[2].collides);
  EXPECT_NEAR(*grasps[1].probability, 1.0 / (1.0 + std::exp(1.0)), 1e-12);
  EXPECT_NEAR(*grasps[2].probability, 1.0 / (1.0 + std::exp(-1.0)), 1e-12);
}

TEST(ScoreModelPlan, ChoosesAmongMoreGraspsThanTheRules) {
  const ScoreModel model = ModelForNarrowGrasps();
  const Boxes boxes{BoxAt(0.0, 0.0, kBox)};
  const auto observation = LookAt(boxes);
  const auto scene = SceneOf(observation, boxes);
  const Arm arm(Vector3d(-0.6, 0.0, 0.0));
  const auto planned = model.Plan(observation, scene, 0, Hand(), arm, {}, {});
  EXPECT_GT(planned.size(), PlanGrasps(scene, 0, Hand(), arm, {}).size());
  EXPECT_TRUE(std::ranges::is_sorted(planned, std::ranges::greater(), [](const Grasp& grasp) {
    return std::pair(!grasp.collides, *grasp.probability);
  }));
}

}  // namespace
}  // namespace rangegrasp::grasp
