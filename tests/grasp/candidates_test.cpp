#include "grasp/internal/candidates.h"

#include <gtest/gtest.h>

#include <set>

#include "base/rng.h"
#include "grasp/fixtures.h"
#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {
namespace {

using namespace test;

/// The first object of a scene, with everything needed for its candidates.
class Workbench {
 public:
  explicit Workbench(const SceneBuilder& builder, const GraspOptions& some_options = {})
      : options(some_options),
        task{builder.scene,
             builder.scene.objects.front(),
             hand,
             arm,
             Vector3d::UnitZ(),
             options,
             SampleObject(builder.scene, builder.scene.objects.front(), 10000),
             SampleObject(builder.scene, builder.scene.objects.front(), 2000).points,
             geometry::Centroid(builder.scene.objects.front().completed_C),
             HandProfiles(hand)} {}

  robot::HandModel hand = SensorHand();
  Arm arm = ArmBase();
  GraspOptions options;
  Task task;
};

GraspOptions AsPublished() {
  GraspOptions options;
  base::SwitchAll<GraspAdditions>(false, options);
  return options;
}

SceneBuilder Box(double x_m, double y_m, double z_m, double yaw_rad = 0.0) {
  SceneBuilder builder;
  builder.AddBox({x_m, y_m, z_m}, At(0.0, 0.0, yaw_rad));
  return builder;
}

View FromAbove(const Task& task, const Vector3d& closing = Vector3d::UnitX()) {
  return MakeView(task, task.coarse, {0.0, 0.0, 0.05}, -Vector3d::UnitZ(), closing);
}

// ---- The object seen along the approach.

TEST(MakeView, MeasuresABoxAlongTheApproach) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  const View view = FromAbove(bench.task);
  // Samples 4 mm apart reach the box's ends within 2 mm; its top is in one plane.
  EXPECT_NEAR(view.top_m, -0.05, 1e-12);
  EXPECT_NEAR(view.bottom_m, 0.05, 1e-12);
  EXPECT_NEAR(view.y_min_m, -0.04, 1e-3);
  EXPECT_NEAR(view.y_max_m, 0.04, 1e-3);
  EXPECT_NEAR(view.table_offset_m, 0.05, 1e-12);
  EXPECT_LT((view.up + Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(view.thumb_to_arm, -1.0, 1e-12);  // the arm is at -x
  const auto slab = SlabAt(view, 0.0, 0.018, 0.07);
  ASSERT_TRUE(slab);
  EXPECT_NEAR(slab->Width(), 0.06, 1e-12);
  EXPECT_NEAR(slab->Middle(), 0.0, 1e-12);
  EXPECT_FALSE(SlabAt(view, 0.2, 0.018, 0.07)) << "beside the box";
}

// For any tilt, a hand that extends this far below T's origin has exactly its clearance.
TEST(TableLimit, LeavesTheClearance) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  base::Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const double tilt = rng.Uniform(0.0, 1.0);
    const double round = rng.Uniform(-base::kPi, base::kPi);
    const Vector3d approach = -(Yaw(round) * TurnX(tilt) * Vector3d::UnitZ());
    const View view = MakeView(bench.task, bench.task.coarse, {0.1, 0.2, 0.3}, approach,
                               Vector3d::UnitX() + 0.1 * Vector3d::UnitZ());
    const double x = rng.Uniform(-0.1, 0.1);
    const double y = rng.Uniform(-0.1, 0.1);
    const double limit = TableLimit(view, 0.07, x, y, 0.004);
    EXPECT_NEAR((view.X_CA * Vector3d(x, y, limit)).z(), 0.07 + 0.004, 1e-12);
  }
}

// A hand of one cell that extends 30 mm down, above the box and next to it.
TEST(DescentLimit, StopsTheHandAboveWhatIsUnderIt) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  const View view = FromAbove(bench.task);
  HandProfiles::Lower lower;
  lower.grid = {-0.01, -0.01, 0.02, 1, 1};
  lower.z = {0.03F};
  EXPECT_NEAR(DescentLimit(view, lower, 0.0, 0.0, 0.002), -0.05 - 0.03 - 0.002, 1e-8);
  EXPECT_GT(DescentLimit(view, lower, 0.2, 0.0, 0.002), 1e6);
}

TEST(UprightAxis, TurnsUpAndRefusesWhatLeansTooMuch) {
  SceneBuilder builder;
  auto& object = builder.AddUprightCylinder(0.03, 0.1, At(0, 0));
  Workbench bench(builder);
  const auto axis_at = [&](double tilt_deg, double sign) {
    object.axis->direction_C = sign * (TurnX(base::Deg(tilt_deg)) * Vector3d::UnitZ());
    return UprightAxis(bench.task);
  };
  EXPECT_NEAR(axis_at(0.0, -1.0)->z(), 1.0, 1e-12);
  EXPECT_NEAR(axis_at(44.9, -1.0)->z(), std::cos(base::Deg(44.9)), 1e-12);
  EXPECT_FALSE(axis_at(45.1, 1.0));
  object.axis.reset();
  EXPECT_FALSE(UprightAxis(bench.task));
}

// ---- Placing.

TEST(Place, PutsThePadsOnBothSidesOfABoxAtTheAimedDepth) {
  for (const double off_m : {0.0, 0.007, -0.02}) {
    SceneBuilder builder;
    builder.AddBox({0.06, 0.08, 0.12}, At(off_m, 0.0));
    Workbench bench(builder);
    const View view = FromAbove(bench.task);
    const Aim aim{0.0, 0.0, view.top_m + 0.02};
    const auto placed =
        Place(bench.task, view, MakeBand(bench.task, view, 0.0), aim, GraspType::kPower);
    ASSERT_TRUE(placed);
    EXPECT_NEAR(placed->depth_m, aim.depth_m, 1e-12);
    // Samples on the pads' curved sides are 2 mm apart, two states 4 mm apart.
    EXPECT_NEAR(placed->grasp.width_m, 0.06, 0.003);
    EXPECT_NEAR(placed->grasp.X_CG.translation().x(), off_m, 0.002);
    EXPECT_GE(placed->grasp.opening_m, 0.08);
    EXPECT_EQ(placed->grasp.opening_m, bench.hand.states[placed->states.wide].gap_m);
    EXPECT_GE(bench.hand.states[placed->states.narrow].gap_m, 0.068);
  }
}

TEST(Place, RefusesWhatIsWiderThanTheHandOrBesideIt) {
  const SceneBuilder builder = Box(0.12, 0.08, 0.12);
  Workbench bench(builder);
  const View view = FromAbove(bench.task);
  const Aim aim{0.0, 0.0, view.top_m + 0.02};
  EXPECT_FALSE(Place(bench.task, view, MakeBand(bench.task, view, 0.0), aim, GraspType::kPower));
  const View across = FromAbove(bench.task, Vector3d::UnitY());
  EXPECT_TRUE(Place(bench.task, across, MakeBand(bench.task, across, 0.0), aim, GraspType::kPower));
  EXPECT_FALSE(
      Place(bench.task, across, MakeBand(bench.task, across, 0.2), aim, GraspType::kPower));
}

// The table blocks this depth: the hand stops, and is also tried 6, 12 and 18 mm higher.
TEST(PlaceAtDepths, BacksOffWhereTheHandHadToStop) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.12);
  Workbench bench(builder);
  const View view = FromAbove(bench.task);
  const Band band = MakeBand(bench.task, view, 0.0);
  std::vector<Candidate> candidates;
  const std::array too_deep{view.bottom_m + 0.1};
  PlaceAtDepths(bench.task, view, band, {}, too_deep, GraspType::kPower, 5, candidates);
  ASSERT_EQ(candidates.size(), 4u);
  for (const Candidate& candidate : candidates) EXPECT_EQ(candidate.group, 5);
  // Higher up, the hand's center may be elsewhere and it may stop earlier: it backs off by at least
  // 6 mm, then by 6 mm each.
  EXPECT_LT(candidates[1].depth_m, candidates[0].depth_m - 0.006 + 1e-9);
  EXPECT_NEAR(candidates[2].depth_m, candidates[1].depth_m - 0.006, 1e-9);
  EXPECT_NEAR(candidates[3].depth_m, candidates[1].depth_m - 0.012, 1e-9);
  // Two reachable depths give one candidate each.
  candidates.clear();
  const std::array fine{view.top_m + 0.02, view.top_m + 0.03};
  PlaceAtDepths(bench.task, view, band, {}, fine, GraspType::kPower, 0, candidates);
  EXPECT_EQ(candidates.size(), 2u);
}

// ---- Candidates by type.

TEST(CylindricalCandidates, StandRoundTheAxis) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.03, 0.14, At(0.1, 0.05));
  Workbench bench(builder, AsPublished());
  const auto candidates = CylindricalCandidates(bench.task);
  ASSERT_EQ(candidates.size(), 24u);
  const Vector3d to_arm = (ArmBase() - Vector3d(0.1, 0.05, ArmBase().z())).normalized();
  std::set<long> angles;
  for (const Candidate& c : candidates) {
    const base::Pose& X_CG = c.grasp.X_CG;
    EXPECT_LT((X_CG.translation().head<2>() - Vector2d(0.1, 0.05)).norm(), 1e-12);
    EXPECT_LT((X_CG.linear().col(2) + Vector3d::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(c.grasp.width_m, 0.06, 0.005);  // two states 4 mm apart
    EXPECT_NEAR(c.grasp.score, X_CG.linear().col(0).dot(to_arm), 1e-12);
    angles.insert(std::lround(base::ToDeg(std::atan2(X_CG.linear()(1, 0), X_CG.linear()(0, 0)))));
  }
  EXPECT_EQ(angles.size(), 24u);
}

// The wall of a cup: the line between the pads is radial, its midpoint is in the middle of the
// wall, 14 mm below the rim, and the pads are on its two sides, in either order.
TEST(RimCandidates, HoldTheWallBetweenThePads) {
  SceneBuilder builder;
  builder.AddCup(0.041, 0.004, 0.095, At(0.03, -0.02));
  Workbench bench(builder);
  const auto candidates = RimCandidates(bench.task);
  ASSERT_EQ(candidates.size(), 48u);
  const Vector2d axis(0.03, -0.02);
  const auto radius = [&](const Vector3d& p) { return (p.head<2>() - axis).norm(); };
  int thumbs_outside = 0;
  const Candidate* best = &candidates.front();
  for (const Candidate& c : candidates) {
    const Grasp& g = c.grasp;
    // With 72 sides, chords are 0.04 mm inside the circle.
    EXPECT_NEAR(radius(g.X_CG.translation()), 0.039, 1e-4);
    EXPECT_NEAR(g.width_m, 0.004, 1e-4);
    EXPECT_LE(0.095 - g.X_CG.translation().z(), 0.014 + 1e-9);
    const Vector2d radial = (g.X_CG.translation().head<2>() - axis).normalized();
    EXPECT_NEAR(std::abs(g.X_CG.linear().col(0).head<2>().dot(radial)), 1.0, 1e-9);
    const auto& held = bench.hand.states[c.states.held];
    const double thumb = radius(g.X_CH * held.thumb_pad_H);
    const double finger = radius(g.X_CH * held.finger_pad_H);
    EXPECT_LT((thumb - 0.039) * (finger - 0.039), 0.0);
    thumbs_outside += thumb > finger;
    if (g.score > best->grasp.score) best = &c;
  }
  EXPECT_EQ(thumbs_outside, 24);
  // No curvature was seen, so the best grasp is next to the arm, with two fingers on the convex
  // side.
  const Vector2d to_arm = (ArmBase().head<2>() - axis).normalized();
  const Vector2d at = (best->grasp.X_CG.translation().head<2>() - axis).normalized();
  EXPECT_GT(at.dot(to_arm), std::cos(base::Deg(7.6)));
  EXPECT_GT(radius(best->grasp.X_CH * bench.hand.states[best->states.held].finger_pad_H), 0.039);
}

TEST(RimCandidates, HoldAClosedTopAcrossItsMiddle) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.03, 0.1, At(0.0, 0.0));
  Workbench bench(builder);
  const auto candidates = RimCandidates(bench.task);
  ASSERT_FALSE(candidates.empty());
  for (const Candidate& c : candidates) {
    EXPECT_LT(c.grasp.X_CG.translation().head<2>().norm(), 0.003);
    EXPECT_NEAR(c.grasp.width_m, 0.06, 0.004);
    EXPECT_EQ(c.grasp.type, GraspType::kRim);
  }
  builder.scene.objects.front().axis.reset();
  EXPECT_TRUE(RimCandidates(bench.task).empty());
}

// Straight down, across the narrow side first, in both hand orientations. The box has no top
// surface, so its directions come from its shape.
TEST(PowerCandidates, CloseAcrossTheNarrowSideBothWaysRound) {
  for (const double yaw : {0.0, 0.4, 1.3, 2.9}) {
    SceneBuilder builder = Box(0.115, 0.06, 0.115, yaw);
    builder.scene.objects.front().top.reset();
    Workbench bench(builder);
    const Vector3d narrow = Yaw(yaw).linear().col(1);
    double best[2] = {-1e9, -1e9};
    double other = -1e9;
    for (const Candidate& c : PowerCandidates(bench.task)) {
      EXPECT_LT((c.grasp.X_CG.linear().col(2) + Vector3d::UnitZ()).norm(), 1e-12);
      const double along = c.grasp.X_CG.linear().col(0).dot(narrow);
      double& score =
          std::abs(along) > std::cos(base::Deg(2.0)) ? best[along > 0.0 ? 0 : 1] : other;
      score = std::max(score, c.grasp.score);
      EXPECT_LE(c.grasp.width_m, bench.task.MaxWidth());
    }
    EXPECT_GT(best[0], other);
    EXPECT_GT(best[1], other);
  }
}

// A top tilted by 20 deg is also approached against its normal; one tilted by 4 or 50 deg is not.
TEST(PowerCandidates, ComeAlongTheNormalOfATiltedTop) {
  for (const double tilt_deg : {4.0, 20.0, 50.0}) {
    SceneBuilder builder = Box(0.115, 0.06, 0.115);
    const Vector3d normal = TurnX(base::Deg(tilt_deg)) * Vector3d::UnitZ();
    SceneBuilder::SetTop({0.0, 0.0, 0.115}, Vector3d::UnitX(), normal, 0.115, 0.06,
                         builder.scene.objects.front());
    Workbench bench(builder);
    bool tilted = false;
    for (const Candidate& c : PowerCandidates(bench.task)) {
      const Vector3d approach = c.grasp.X_CG.linear().col(2);
      const bool down = approach.z() < -1.0 + 1e-12;
      tilted = tilted || !down;
      if (!down) {
        EXPECT_LT((approach + normal).norm(), 1e-9);
      }
    }
    EXPECT_EQ(tilted, tilt_deg == 20.0);
  }
}

// ---- The method as published.

// The tool centre is that of the fingertips and moves with the opening. For any width, it is above
// the center of the top, with the box between thumb and fingers, from the left and from the right,
// and the hand moves down past the top.
TEST(PublishedPowerCandidates, BringTheTipsCentreOverTheTopWithTheBoxBetween) {
  for (const double width_m : {0.02, 0.045, 0.06, 0.075}) {
    SceneBuilder builder;
    builder.AddBox({0.10, width_m, 0.12}, At(0.04, -0.03, 0.3));
    Workbench bench(builder, AsPublished());
    const auto candidates = PowerCandidates(bench.task);
    ASSERT_EQ(candidates.size(), 2u) << width_m;
    const Vector3d across = Yaw(0.3).linear().col(1);
    double sides = 0.0;
    for (const Candidate& c : candidates) {
      EXPECT_TRUE(c.to_contact);
      const auto& open = bench.hand.states[c.states.wide];
      EXPECT_GE(open.gap_m, width_m);
      // The tool centre when the hand is as wide as the box; two states are 4 mm apart.
      const auto& held = bench.hand.states[bench.hand.IndexAtGap(width_m)];
      const Vector3d tool = c.grasp.X_CH * held.power_center_H;
      EXPECT_LT((tool - Vector3d(0.04, -0.03, tool.z())).norm(), 1e-9) << width_m;
      EXPECT_LT((c.grasp.X_CG.translation() - tool).norm(), 1e-9);
      EXPECT_LT(tool.z(), 0.12 - 0.025) << "the palm or the thumb's root meets the top";
      EXPECT_LT((c.grasp.X_CG.linear().col(2) + Vector3d::UnitZ()).norm(), 1e-9);
      // They are on either side of the box, with clearance.
      const double thumb = (c.grasp.X_CH * open.thumb_pad_H - tool).dot(across);
      const double finger = (c.grasp.X_CH * open.finger_pad_H - tool).dot(across);
      EXPECT_GT(std::abs(thumb), 0.5 * width_m);
      EXPECT_GT(std::abs(finger), 0.5 * width_m);
      EXPECT_LT(thumb * finger, 0.0);
      sides += thumb > 0.0 ? 1.0 : -1.0;
    }
    EXPECT_EQ(sides, 0.0) << "from the left and from the right";
  }
}

// No part of the open hand touches the box at the lowest position that the collision check allows.
TEST(PublishedPowerCandidates, AreFreeAtTheLowestPlace) {
  for (const double width_m : {0.02, 0.045, 0.06, 0.075}) {
    SceneBuilder builder = Box(0.10, width_m, 0.12);
    Workbench bench(builder, AsPublished());
    const collision::HandCollider collider(bench.hand, {}, builder.scene.objects[0].surface_C,
                                           {Vector3d::UnitZ(), 0.0}, {0.002, 0.004});
    Collected found;
    ChooseFree(collider, bench.task, PowerCandidates(bench.task), {24, 4, 120}, found);
    EXPECT_EQ(found.free.size(), 2u) << width_m;
    for (const Grasp& g : found.free) {
      EXPECT_FALSE(collider.HitsOwn(g.X_CH, bench.hand.IndexAtGap(g.opening_m - 1e-6)));
      EXPECT_LT((g.X_CH * bench.hand.AtGap(width_m).power_center_H).z(), 0.12 - 0.02)
          << "not on top of it";
    }
  }
}

TEST(PublishedPowerCandidates, AFullyOpenHandIsAChoiceOfItsOwn) {
  const SceneBuilder builder = Box(0.10, 0.03, 0.12);
  GraspOptions options = AsPublished();
  options.preshape = false;
  Workbench bench(builder, options);
  const auto candidates = PowerCandidates(bench.task);
  ASSERT_FALSE(candidates.empty());
  for (const Candidate& c : candidates) EXPECT_EQ(c.states.wide, 0u);
}

// The published cylindrical grasp: the midpoint of thumb and index tip is on the axis, halfway up.
TEST(PublishedCylindricalCandidates, BringTheTipsCentreOntoTheAxis) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.03, 0.14, At(0.1, 0.05));
  Workbench bench(builder, AsPublished());
  const auto candidates = CylindricalCandidates(bench.task);
  ASSERT_FALSE(candidates.empty());
  for (const Candidate& c : candidates) {
    const auto& held = bench.hand.states[bench.hand.IndexAtGap(0.06)];
    const Vector3d tool = c.grasp.X_CH * held.tip_center_H;
    EXPECT_LT((tool - Vector3d(0.1, 0.05, tool.z())).norm(), 1e-9);
    EXPECT_GE(tool.z(), 0.07 - 1e-9) << "half way up, or as deep as the hand goes";
  }
}

// Each switch alone changes what its name says, and nothing else.
TEST(GraspAdditions, EachAloneChangesThePublishedCandidates) {
  SceneBuilder builder = Box(0.10, 0.05, 0.12);
  const auto with = [&](bool GraspAdditions::*on) {
    GraspOptions options = AsPublished();
    options.*on = true;
    Workbench bench(builder, options);
    auto candidates = PowerCandidates(bench.task);
    EXPECT_FALSE(candidates.empty());
    return candidates;
  };
  for (const Candidate& c : with(&GraspAdditions::pitches)) EXPECT_GE(c.grasp.pitch_rad, 0.0);
  EXPECT_GT(with(&GraspAdditions::pitches).front().grasp.pitch_rad, 0.1);
  for (const Candidate& c : with(&GraspAdditions::centering)) {
    EXPECT_EQ(c.grasp.pitch_rad, 0.0);
    EXPECT_TRUE(c.to_contact);
  }
  for (const Candidate& c : with(&GraspAdditions::depths)) EXPECT_FALSE(c.to_contact);
  EXPECT_GT(with(&GraspAdditions::directions).size(), 2u);
  EXPECT_GT(with(&GraspAdditions::offsets).size(), 2u);
  EXPECT_EQ(with(&GraspAdditions::contact_ranking).size(), 2u);
  for (const Candidate& c : with(&GraspAdditions::narrow_openings)) {
    EXPECT_GT(c.states.narrow, c.states.wide) << "states close as they go on";
  }
}

// The published method grasps over the top of what is wider than the hand, in both orientations.
TEST(PowerCandidates, AreNoneWhereThePadsCannotReachRoundTheObject) {
  SceneBuilder builder = Box(0.20, 0.16, 0.10);
  Workbench published(builder, AsPublished());
  EXPECT_EQ(PowerCandidates(published.task).size(), 2u);
  Workbench ours(builder, GraspOptions{});
  EXPECT_TRUE(PowerCandidates(ours.task).empty());
}

// ---- Choosing.

/// A candidate with the open hand high above the table, or in it.
Candidate Standing(const robot::HandModel& hand, double score, int group, bool free) {
  Candidate c;
  c.grasp.X_CH = Move(0.0, 0.0, free ? 1.0 : -1.0);
  c.grasp.score = score;
  c.group = group;
  c.states.held = hand.states.size() - 1;
  return c;
}

TEST(ChooseFree, TakesTheBestOfEveryGroupWithinItsQuota) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  const collision::HandCollider collider(bench.hand, {}, {}, {}, {});
  std::vector<Candidate> candidates;
  for (int i = 0; i < 12; ++i) {
    // There are three groups, scores rise, and every fourth candidate collides.
    candidates.push_back(Standing(bench.hand, 0.1 * i, i % 3, i % 4 != 0));
  }
  const auto scores = [](const std::vector<Grasp>& grasps) {
    std::vector<double> tenths;
    for (const Grasp& g : grasps) tenths.push_back(std::round(10.0 * g.score));
    return tenths;
  };
  Collected found;
  const auto choose = [&](const Quota& quota) {
    found = {};
    ChooseFree(collider, bench.task, candidates, quota, found);
    for (const Grasp& g : found.free) EXPECT_FALSE(g.collides);
    for (const Grasp& g : found.colliding) EXPECT_TRUE(g.collides);
    return scores(found.free);
  };
  // 11 (group 2), 10 (1), 9 (0): then every group has one.
  EXPECT_EQ(choose({24, 1, 120}), (std::vector<double>{11, 10, 9}));
  EXPECT_TRUE(found.colliding.empty());
  // 8 collides; 7, 6, 5 are the second ones of their groups, in turn.
  EXPECT_EQ(choose({24, 2, 120}), (std::vector<double>{11, 10, 9, 7, 6, 5}));
  EXPECT_EQ(scores(found.colliding), (std::vector<double>{8}));
  EXPECT_EQ(choose({2, 4, 120}), (std::vector<double>{11, 10}));
  EXPECT_EQ(choose({24, 4, 5}), (std::vector<double>{11, 10, 9, 7}));
  choose({24, 4, 120});
  EXPECT_EQ(scores(found.colliding), (std::vector<double>{8, 4, 0})) << "the best of each group";
}

// Grasps that the arm does not reach do not displace reachable ones, and keep their verdict.
TEST(ChooseFree, LeavesAsideWhatTheArmDoesNotReach) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  const collision::HandCollider collider(bench.hand, {}, {}, {}, {});
  std::vector<Candidate> candidates;
  for (int i = 0; i < 6; ++i) {
    candidates.push_back(Standing(bench.hand, 1.0 - 0.1 * i, 0, true));
    candidates.back().grasp.X_CH.translation().x() = i;
  }
  bench.arm.reaches = [](const base::Pose& X_CH) { return X_CH.translation().x() > 1.5; };
  const auto choose = [&] {
    Collected found;
    ChooseFree(collider, bench.task, candidates, {24, 2, 120}, found);
    return found;
  };
  const Collected found = choose();
  ASSERT_EQ(found.free.size(), 2u);
  EXPECT_EQ(found.free.front().X_CH.translation().x(), 2.0) << "the best within reach";
  ASSERT_EQ(found.unreachable.size(), 2u);
  EXPECT_FALSE(found.unreachable.front().collides);
  bench.options.reachable = false;
  EXPECT_EQ(choose().free.front().X_CH.translation().x(), 0.0) << "as published";
}

// If the hand grazes the object, it is moved up until it does not.
TEST(ChooseFree, LiftsAHandThatGrazesTheObject) {
  const SceneBuilder builder = Box(0.06, 0.08, 0.1);
  Workbench bench(builder);
  double lowest = 1e9;
  for (const geometry::Shape& shape : bench.hand.states.front().shapes) {
    for (const Vector3d& p : geometry::Tessellate(shape, 64).vertices) {
      lowest = std::min(lowest, p.z());
    }
  }
  for (const auto& [deep_m, lift_m] : {std::pair{0.0010, 0.002}, {0.0030, 0.004}}) {
    // A plate under the open hand, with its top deep_m above the hand's lowest point.
    const auto plate = geometry::Transformed(Extrude(Rectangle(0.5, 0.5), 0.001), Move(0, 0, 0.5));
    const collision::HandCollider collider(bench.hand, {}, plate, {}, {});
    Candidate c = Standing(bench.hand, 1.0, 0, true);
    c.states.held = 0;
    c.grasp.X_CG.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
    c.grasp.X_CH = Move(0.0, 0.0, 0.501 - deep_m - lowest);
    Collected found;
    ChooseFree(collider, bench.task, {c}, {}, found);
    ASSERT_EQ(found.free.size(), 1u);
    EXPECT_NEAR(found.free.front().X_CH.translation().z(), c.grasp.X_CH.translation().z() + lift_m,
                1e-12);
  }
}

template <typename Height>
geometry::Points Patch(double half_m, Height height) {
  geometry::Points points;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const double x = half_m * i / 6;
      const double y = half_m * j / 6;
      points.emplace_back(x, y, height(x, y));
    }
  }
  return points;
}

TEST(GaussianCurvature, OfASphereIsOneOverItsRadiusSquared) {
  for (const double R : {0.03, 0.1}) {
    const auto points =
        Patch(0.1 * R, [R](double x, double y) { return std::sqrt(R * R - x * x - y * y); });
    const auto K = GaussianCurvature(points, Vector3d(0, 0, R));
    ASSERT_TRUE(K);
    // The quadric omits the sphere's fourth-order terms: (0.1)^2 of the curvature.
    EXPECT_NEAR(*K * R * R, 1.0, 0.03);
  }
}

TEST(GaussianCurvature, OfACylinderIsZeroAndOfASaddleNegative) {
  const double R = 0.04;
  const auto cylinder = Patch(0.006, [R](double x, double) { return std::sqrt(R * R - x * x); });
  EXPECT_NEAR(GaussianCurvature(cylinder, Vector3d(0, 0, R)).value() * R * R, 0.0, 1e-6);
  const auto saddle = Patch(0.004, [](double x, double y) { return 10.0 * x * x - 7.0 * y * y; });
  // K = (2 * 10) (2 * -7) at the centre.
  EXPECT_NEAR(GaussianCurvature(saddle, Vector3d::Zero()).value(), -280.0, 0.05);
}

TEST(GaussianCurvature, CountsTheMixedTerm) {
  // Three times longer along x, so that the principal axes are x and y and h = 8 x y is mixed:
  // K = -8^2.
  geometry::Points points;
  for (int i = -9; i <= 9; ++i) {
    for (int j = -3; j <= 3; ++j) {
      points.emplace_back(0.001 * i, 0.001 * j, 8.0 * 0.001 * i * 0.001 * j);
    }
  }
  EXPECT_NEAR(GaussianCurvature(points, Vector3d::Zero()).value(), -64.0, 0.5);
}

TEST(GaussianCurvature, NeedsAPatch) {
  EXPECT_FALSE(GaussianCurvature(geometry::Points(5, Vector3d::Zero()), Vector3d::Zero()));
  geometry::Points line;
  for (int i = 0; i < 20; ++i) line.emplace_back(0.001 * i, 0.0, 0.0);
  EXPECT_FALSE(GaussianCurvature(line, Vector3d::Zero()));
}

TEST(SmoothAround, KeepsAConstantAndWrapsRound) {
  std::vector<double> angles, ones, pulse;
  for (int k = 0; k < 24; ++k) {
    angles.push_back(2.0 * base::kPi * k / 24);
    ones.push_back(3.0);
    pulse.push_back(k == 0 ? 1.0 : 0.0);
  }
  for (const double v : SmoothAround(angles, ones, 0.2)) EXPECT_NEAR(v, 3.0, 1e-12);
  const auto smooth = SmoothAround(angles, pulse, 0.2);
  EXPECT_NEAR(smooth[1], smooth[23], 1e-12);
  EXPECT_GT(smooth[0], smooth[1]);
  EXPECT_GT(smooth[1], smooth[2]);
}

TEST(DescribeRim, MeasuresTheWallOfACup) {
  SceneBuilder builder;
  const auto& cup = builder.AddCup(0.041, 0.004, 0.095, At(0.03, -0.02));
  const auto rim = DescribeRim(builder.scene, cup, Vector3d::UnitZ(), Vector3d::UnitX(), 24);
  ASSERT_EQ(rim.size(), 24u);
  for (const RimSector& sector : rim) {
    // With 72 sides, chords are R (1 - cos 2.5 deg) = 0.04 mm inside the circle.
    EXPECT_NEAR(sector.wall_m, 0.004, 1e-4);
    EXPECT_NEAR(sector.radius_m, 0.039, 1e-4);
  }
}

TEST(DescribeRim, FindsTheStrongestCurvature) {
  SceneBuilder builder;
  auto& cup = builder.AddCup(0.041, 0.004, 0.095, At(0.0, 0.0));
  // A bead on the rim at 90 deg.
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j <= 10; ++j) {
      const double a = 2.0 * base::kPi * i / 40;
      const double b = 0.5 * base::kPi * j / 10;
      cup.points.push_back(static_cast<std::uint32_t>(builder.scene.cloud.points.size()));
      builder.scene.cloud.points.push_back(
          Vector3d(0.0, 0.045, 0.095) +
          0.004 * Vector3d(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b)));
      if (j == 0 && i == 0) cup.top->rim.push_back(cup.points.back());
    }
  }
  const auto rim = DescribeRim(builder.scene, cup, Vector3d::UnitZ(), Vector3d::UnitX(), 24);
  EXPECT_DOUBLE_EQ(rim[6].curvature, 1.0);
  EXPECT_LT(rim[12].curvature, 0.1);
}

}  // namespace
}  // namespace rangegrasp::grasp::internal
