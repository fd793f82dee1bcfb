#include "grasp/named_grasps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "error_of.h"
#include "grasp/fixtures.h"
#include "temp_folder.h"

namespace rangegrasp::grasp {
namespace {

using namespace rangegrasp::grasp::test;
using testing::HasSubstr;
using testing_support::TempFolder;

// A bar of 12 mm, 80 mm tall, grasped from above in both closing directions and in quarter turns.
constexpr const char* kBar = R"(
up: [0, 0, 1]
grasps:
  body:
    for: [hand_over]
    at_mm: [0, 0, 60]
    approach: [0, 0, -1]
    closing: [1, 0, 0]
    width_mm: 12
    turns_deg: [0, 270, 90]
    either_way: true
  side:
    for: [pour]
    upright: true
    at_mm: [0, 0, 60]
    approach: [-1, 0, 0]
    closing: [0, 1, 0]
    width_mm: 12
keep_free:
  foot:
    from_mm: [-10, -10, 0]
    to_mm: [10, 10, 20]
)";

NamedGrasps Read(const std::string& text) {
  const TempFolder folder;
  return ReadNamedGrasps(folder.Write("grasps.yaml", text));
}

std::string ErrorOf(const std::string& text) {
  return testing_support::ErrorOf([&] { Read(text); });
}

perception::Scene SceneOf(const std::vector<geometry::TriangleMesh>& meshes_W) {
  SceneBuilder builder;
  for (const auto& mesh_W : meshes_W) builder.Add(mesh_W);
  return builder.scene;
}

std::vector<PlacedGrasp> Placed(const std::string& use, const std::vector<base::Pose>& poses_CO,
                                const perception::Scene& scene) {
  return PlaceNamedGrasps(Read(kBar), use, poses_CO, scene, 0, Hand(), GraspOptions{}, {});
}

perception::Scene BarAt(const base::Pose& X_CO) {
  return SceneOf({geometry::Transformed(Extrude(Rectangle(0.012, 0.012), 0.08), X_CO)});
}

TEST(NamedGrasps, AreReadWithAllTheirWays) {
  const NamedGrasps known = Read(kBar);
  ASSERT_EQ(known.grasps.size(), 2u);
  EXPECT_EQ(known.grasps[0].name, "body");
  EXPECT_EQ(known.grasps[0].ways_O.size(), 8u);  // four turns in two closing directions
  EXPECT_EQ(known.grasps[1].ways_O.size(), 1u);
  EXPECT_TRUE(IsFor(known.grasps[1], "pour"));
  EXPECT_TRUE(IsFor(known.grasps[1], ""));
  EXPECT_FALSE(IsFor(known.grasps[1], "drink"));
  for (const Proposal& way : known.grasps[0].ways_O) {
    EXPECT_NEAR(way.X_CG.linear().determinant(), 1.0, 1e-9);
    EXPECT_NEAR(way.approach_C.z(), -1.0, 1e-9);
  }
}

TEST(NamedGrasps, TheirNumberFollowsFromTheStepsAlone) {
  const auto ways = [](const std::string& leans) {
    return Read(
               "grasps:\n  body:\n    at_mm: [0, 0, 60]\n    approach: [0, 0, -1]\n"
               "    closing: [1, 0, 0]\n    width_mm: 12\n    leans_deg: " +
               leans)
        .grasps.front()
        .ways_O.size();
  };
  EXPECT_EQ(ways("[0, 0, 1e-300]"), 1u);
  EXPECT_EQ(ways("[0, 0.3, 0.1]"), 4u);  // 0.3 / 0.1 is below 3 in doubles
  EXPECT_EQ(ways("[-75, 0, 15]"), 6u);
  EXPECT_EQ(ways("[0, 10, 15]"), 1u);
}

TEST(NamedGrasps, TheirUsesAreThoseOfAll) {
  EXPECT_EQ(UsesOf(Read(kBar)), (std::set<std::string>{"hand_over", "pour"}));
}

// Both grasps of the bar close to 12 mm.
TEST(NamedGrasps, ThoseThatCannotBeMeantAreWarnedOf) {
  const auto warnings = [](double side_m, double height_m, std::optional<double> opens_m = {}) {
    const auto bar_O = Extrude(Rectangle(side_m, side_m), height_m);
    std::vector<std::string> what;
    for (const auto& f : CheckNamedGrasps(Read(kBar), "grasps.yaml", bar_O.vertices, opens_m)) {
      EXPECT_FALSE(f.error);
      EXPECT_EQ(f.where, "grasps.yaml");
      what.push_back(f.element + ": " + f.what);
    }
    return what;
  };
  EXPECT_EQ(warnings(0.012, 0.08, 0.05).size(), 0u);
  EXPECT_THAT(warnings(0.012, 0.02).at(0), HasSubstr("grasp 'body': its center (0, 0, 60) mm is"));
  EXPECT_THAT(warnings(0.006, 0.08).at(1), HasSubstr("'side': its width_mm is 12, but the whole"));
  EXPECT_THAT(warnings(0.012, 0.08, 0.01).at(0), HasSubstr("the hand opens only 10 mm"));
}

TEST(NamedGrasps, WithoutAFileThereAreNone) {
  EXPECT_TRUE(ReadNamedGrasps("/nonexistent/grasps.yaml").grasps.empty());
}

TEST(NamedGrasps, WhatIsWrongIsNamedWithItsLine) {
  const auto error = [](const std::string& more) {
    return ErrorOf("grasps:\n  body:\n    at_mm: [0, 0, 60]\n    approach: [0, 0, -1]\n" + more);
  };
  EXPECT_THAT(error("    closing: [0, 0, 1]\n    width_mm: 12\n"), HasSubstr("perpendicular"));
  EXPECT_THAT(error("    closing: [1, 0]\n    width_mm: 12\n"), HasSubstr("not 3"));
  EXPECT_THAT(error("    closing: [1, x, 0]\n    width_mm: 12\n"), HasSubstr("'x'"));
  EXPECT_THAT(error("    closing: [1, 0, 0]\n"), HasSubstr("width_mm"));
  EXPECT_THAT(error("    closing: [1, 0, 0]\n    widht_mm: 12\n"), HasSubstr("'widht_mm'"));
  const std::string good = "    closing: [1, 0, 0]\n    width_mm: 12\n";
  EXPECT_THAT(error(good + "    turn_deg: [0, 1, 1]\n"), HasSubstr("turns_deg"));
  EXPECT_THAT(error(good + "    turns_deg: [0, 90, 0]\n"), HasSubstr("STEP"));
  EXPECT_THAT(error(good + "    turns_deg: [90, 0, 15]\n"), HasSubstr("FROM <= TO"));
  EXPECT_THAT(error(good + "    leans_deg: [1e300, 1e300, 15]\n"), HasSubstr("TO <= 360"));
  EXPECT_THAT(error(good + "    leans_deg: [-361, 0, 15]\n"), HasSubstr("-360 <= FROM"));
  EXPECT_THAT(ErrorOf("keep_free:\n  foot:\n    from_mm: [0, 0, 0]\n    to_mm: [0, 1, 1]\n"),
              HasSubstr("grasps.yaml"));
}

TEST(NamedGrasps, StandWhereTheObjectStands) {
  const base::Pose X_CO = At(0.05, -0.02, base::Deg(30.0));
  const auto placed = Placed("hand_over", {X_CO}, BarAt(X_CO));
  ASSERT_EQ(placed.size(), 8u);
  for (const PlacedGrasp& one : placed) {
    EXPECT_EQ(one.grasp.type, GraspType::kNamed);
    EXPECT_FALSE(one.grasp.collides);
    EXPECT_NEAR((one.grasp.X_CG.translation() - X_CO * Vector3d(0, 0, 0.06)).norm(), 0.0, 1e-9);
  }
}

TEST(NamedGrasps, UprightOnesAreForWhatStands) {
  const auto count = [](const base::Pose& X_CO) {
    return Placed("pour", {X_CO}, BarAt(X_CO)).size();
  };
  EXPECT_EQ(count(At(0.0, 0.0)), 1u);
  const Eigen::AngleAxisd lying(base::Deg(90.0), Vector3d::UnitX());
  EXPECT_EQ(count(base::MakePose(lying.matrix(), {0.0, 0.0, 0.006})), 0u);
}

// The bar of 80 mm looks the same upside down.
TEST(NamedGrasps, AreTriedInEveryPoseThatLooksTheSame) {
  const base::Pose X_CO = At(0.05, -0.02, base::Deg(30.0));
  const base::Pose X_upside_down =
      X_CO * base::MakePose(Vector3d(1.0, -1.0, -1.0).asDiagonal(), {0.0, 0.0, 0.08});
  const auto scene = BarAt(X_CO);
  ASSERT_TRUE(Placed("hand_over", {X_upside_down}, scene).front().grasp.collides)
      << "the hand comes from below";
  const auto placed = Placed("hand_over", {X_upside_down, X_CO}, scene);
  ASSERT_EQ(placed.size(), 16u);
  for (std::size_t i = 0; i < placed.size(); ++i) EXPECT_EQ(placed[i].grasp.collides, i >= 8) << i;
  EXPECT_EQ(Placed("pour", {X_upside_down, X_CO}, scene).size(), 1u) << "upright in one of them";
}

TEST(NamedGrasps, AnotherObjectInTheWayIsSeen) {
  auto scene = SceneOf(
      {Extrude(Rectangle(0.012, 0.012), 0.08),
       geometry::Transformed(Extrude(Rectangle(0.04, 0.2), 0.1),
                             base::MakePose(Eigen::Matrix3d::Identity(), {0.05, 0.0, 0.0}))});
  const auto placed = Placed("hand_over", {At(0.0, 0.0)}, scene);
  ASSERT_FALSE(placed.empty());
  // Closing along x hits the wall; closing across it is free in some turns of the hand.
  int free = 0;
  for (const PlacedGrasp& one : placed) {
    const bool along_x = std::abs(one.grasp.X_CG.linear().col(0).x()) > 0.9;
    free += one.grasp.collides ? 0 : 1;
    EXPECT_TRUE(!along_x || one.grasp.collides);
  }
  EXPECT_GT(free, 0);
  EXPECT_FALSE(placed.front().grasp.collides) << "free ones come first";
}

TEST(KeptFree, IsTouchedByAHandThatReachesIntoIt) {
  const NamedGrasps known = Read(kBar);
  const base::Pose X_CO = At(0.02, 0.01, base::Deg(70.0));
  const auto hand_at = [&](double z_m) {
    Proposal proposal;
    proposal.X_CG = X_CO * base::MakePose(Vector3d(1.0, -1.0, -1.0).asDiagonal(), {0, 0, z_m});
    proposal.width_m = 0.012;
    return PlaceHand(proposal, Hand(), {});
  };
  EXPECT_FALSE(TouchesKeptFree(hand_at(0.07), known, X_CO, Hand()));
  EXPECT_TRUE(TouchesKeptFree(hand_at(0.015), known, X_CO, Hand()));
}

}  // namespace
}  // namespace rangegrasp::grasp
