#include "grasp/grasp.h"

#include <gtest/gtest.h>

#include <set>

#include "base/words.h"
#include "geometry/shape.h"
#include "grasp/fixtures.h"
#include "grasp/internal/closing.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;
using internal::CloseOn;
using internal::HandProfiles;

std::vector<Grasp> Plan(const SceneBuilder& builder, const GraspOptions& options) {
  return PlanGrasps(builder.scene, 0, Hand(), ArmBase(), options);
}

std::vector<Grasp> Plan(const SceneBuilder& builder, bool improved = true) {
  GraspOptions options;
  base::SwitchAll<GraspAdditions>(improved, options);
  return Plan(builder, options);
}

std::size_t Free(const std::vector<Grasp>& grasps) {
  return static_cast<std::size_t>(
      std::count_if(grasps.begin(), grasps.end(), [](const Grasp& g) { return !g.collides; }));
}

/// Checks properties that every list of grasps must have.
void ExpectSound(const SceneBuilder& builder, const std::vector<Grasp>& grasps) {
  const robot::HandModel& hand = Hand();
  const geometry::Points dots = Dots(builder.scene.objects[0].surface_C, 0.004);
  ASSERT_FALSE(grasps.empty());
  ASSERT_LE(grasps.size(), 24u);
  bool collided = false;
  for (const Grasp& g : grasps) {
    EXPECT_GE(g.collides, collided) << "those that collide come last";
    collided = g.collides;
    const Eigen::Matrix3d expected = g.X_CG.linear() *
                                     Eigen::AngleAxisd(-g.pitch_rad, Vector3d::UnitY()) *
                                     hand.X_HG_tip.linear().transpose();
    EXPECT_LT((g.X_CH.linear() - expected).norm(), 1e-9);
    EXPECT_LE(g.opening_m, hand.MaxGap());
    EXPECT_GE(g.opening_m, std::min(g.width_m, hand.MaxGap()) - 0.003);
    if (g.collides) continue;
    const auto& open = hand.states[hand.IndexAtGap(g.opening_m - 1e-6)];
    for (const geometry::Shape& shape : open.shapes) {
      geometry::Shape inner = geometry::Grown(shape, -0.0006);  // facets
      inner.X_BS = g.X_CH * shape.X_BS;
      for (const Vector3d& p : dots) EXPECT_FALSE(geometry::Inside(inner, p));
    }
    for (const auto& state : hand.states) {
      if (state.gap_m > g.opening_m + 1e-9 || state.gap_m < g.width_m) continue;
      for (const geometry::Shape& shape : state.shapes) {
        EXPECT_GE(-geometry::Support(shape, g.X_CH, -Vector3d::UnitZ()), 0.004 - 2e-6)
            << "above the table";
      }
    }
  }
}

TEST(PlanGrasps, ClosesAcrossTheNarrowSideOfABoxAtItsMiddle) {
  for (const double yaw : {0.0, 0.4, 1.3, 2.9}) {
    SceneBuilder builder;
    const base::Pose X_WO = At(0.03, -0.05, yaw);
    builder.AddBox({0.115, 0.06, 0.115}, X_WO);
    const auto grasps = Plan(builder);
    ExpectSound(builder, grasps);
    const Grasp& best = grasps.front();
    EXPECT_FALSE(best.collides);
    EXPECT_EQ(best.type, GraspType::kPower);
    EXPECT_GT(std::abs(best.X_CG.linear().col(0).dot(X_WO.linear().col(1))), std::cos(0.02));
    EXPECT_NEAR(best.X_CG.linear()(2, 2), -1.0, 1e-9);
    // Samples are 2 mm apart, with about 30 of them under a contact.
    EXPECT_LT((best.X_CG.translation() - X_WO.translation()).head<2>().norm(), 0.002);
    EXPECT_NEAR(best.width_m, 0.06, 0.003);
    EXPECT_LT(best.X_CG.translation().z(), 0.115 - 0.01);
    EXPECT_GE(Free(grasps), 8u);
  }
}

TEST(PlanGrasps, OffersBothSidesAndMoreThanOnePitch) {
  SceneBuilder builder;
  builder.AddBox({0.09, 0.06, 0.135}, At(0, 0, 0.2));
  bool left = false, right = false;
  std::set<long> pitches;
  for (const Grasp& g : Plan(builder)) {
    const double side = g.X_CG.linear().col(0).dot(Yaw(0.2).linear().col(1));
    left |= !g.collides && side > 0.9;
    right |= !g.collides && side < -0.9;
    pitches.insert(std::lround(base::ToDeg(g.pitch_rad)));
  }
  EXPECT_TRUE(left && right);
  EXPECT_GE(pitches.size(), 2u);
}

TEST(PlanGrasps, UsesTheNarrowerAxisWhereTheTopSurfaceNamesTheOther) {
  SceneBuilder builder;
  auto& object = builder.AddBox({0.06, 0.115, 0.1}, At(0, 0));
  // Only half of the top was seen, so its principal axis lies across the box.
  SceneBuilder::SetTop(Vector3d(0, 0.04, 0.1), Vector3d::UnitX(), Vector3d::UnitZ(), 0.06, 0.04,
                       object);
  const auto grasps = Plan(builder);
  ExpectSound(builder, grasps);
  EXPECT_GT(std::abs(grasps.front().X_CG.linear()(0, 0)), std::cos(0.02));
  EXPECT_NEAR(grasps.front().X_CG.translation().y(), 0.0, 0.003);
}

TEST(PlanGrasps, StandsMidwayBetweenTheContacts) {
  // One side is vertical and the other leans, so the midpoint changes with the height.
  SceneBuilder builder;
  builder.AddLying({{-0.025, 0}, {0.040, 0}, {0.020, 0.07}, {-0.025, 0.07}}, 0.12, 0.0, 0.07, 0.045,
                   At(0, 0));
  const auto grasps = Plan(builder);
  ExpectSound(builder, grasps);
  HandProfiles profiles(Hand());
  auto surface = SampleSurface(builder.scene.objects[0].surface_C, 10000);
  for (std::size_t i = 0; i < 3; ++i) {
    const Grasp& g = grasps[i];
    const base::Pose X_TC = HandProfiles::X_TH(Hand(), g.pitch_rad) * g.X_CH.inverse();
    geometry::Points points, normals;
    for (const Vector3d& p : surface.points) points.push_back(X_TC * p);
    for (const Vector3d& n : surface.normals) normals.push_back(X_TC.linear() * n);
    const auto closing = CloseOn(profiles, g.pitch_rad, Hand().IndexAtGap(g.opening_m - 1e-6),
                                 points, normals, surface.area_m2, Vector3d::Zero());
    ASSERT_TRUE(closing);
    EXPECT_LT(std::abs(closing->drag_m), 0.002);
  }
}

TEST(PlanGrasps, AsPublishedPutsTheToolCentreOverTheTopsCentre) {
  SceneBuilder builder;
  const base::Pose X_WO = At(0.02, 0.06, 0.5);
  builder.AddBox({0.115, 0.06, 0.115}, X_WO);
  const auto grasps = Plan(builder, false);
  ExpectSound(builder, grasps);
  ASSERT_EQ(grasps.size(), 2u);
  for (const Grasp& g : grasps) {
    EXPECT_EQ(g.pitch_rad, 0.0);
    EXPECT_GE(g.opening_m, 0.06);
    EXPECT_LT(g.opening_m, 0.06 + 0.02 + 0.005);  // two states 4 to 5 mm apart
    EXPECT_LT((g.X_CG.translation() - X_WO.translation()).head<2>().norm(), 1e-9);
    EXPECT_LT((g.X_CH * Hand().AtGap(0.06).power_center_H - g.X_CG.translation()).norm(), 1e-9);
    EXPECT_LT(g.X_CG.translation().z(), 0.115);
  }
  EXPECT_LT((grasps[0].X_CG.linear().col(0) + grasps[1].X_CG.linear().col(0)).norm(), 1e-9);
  EXPECT_GE(grasps[0].score, grasps[1].score);
}

// "Shifted down to a possible collision with the grasping object", then checked against the others
// (section 5.2): the hand does not go up to where lower neighbors are free.
TEST(PlanGrasps, AsPublishedCollidesWithNeighborsBesideItsObject) {
  SceneBuilder builder;
  builder.AddBox({0.115, 0.06, 0.115}, At(0.0, 0.0, 0.0));
  const auto alone = Plan(builder, false);
  ASSERT_FALSE(alone.empty());
  EXPECT_FALSE(alone.front().collides);
  for (const double side : {1.0, -1.0}) {
    builder.AddBox({0.115, 0.06, 0.10}, At(0.0, side * 0.09, 0.0));  // the open hand meets it
  }
  const auto between = Plan(builder, false);
  ASSERT_FALSE(between.empty());
  for (const Grasp& g : between) EXPECT_TRUE(g.collides);
}

TEST(PlanGrasps, AsPublishedAlignsTheHandWithATiltedTop) {
  SceneBuilder builder;
  const double tilt = 0.4;
  const auto mesh = Transformed(Extrude(Rectangle(0.1, 0.05), 0.06), Move(0, 0, 0.1) * TurnX(tilt));
  auto& object = builder.Add(mesh);
  const Vector3d normal = TurnX(tilt).linear().col(2);
  SceneBuilder::SetTop(Vector3d(0, 0, 0.1) + 0.06 * normal, Vector3d::UnitX(), normal, 0.1, 0.05,
                       object);
  const auto grasps = Plan(builder, false);
  ASSERT_FALSE(grasps.empty());
  for (const Grasp& g : grasps) {
    EXPECT_LT((g.X_CG.linear().col(2) + normal).norm(), 1e-9);
  }
}

TEST(PlanGrasps, HoldsACylinderOnItsAxis) {
  for (const double radius : {0.02575, 0.035, 0.0425}) {
    SceneBuilder builder;
    const base::Pose X_WO = At(-0.04, 0.03);
    builder.AddUprightCylinder(radius, 0.1, X_WO);
    const auto grasps = Plan(builder);
    ExpectSound(builder, grasps);
    std::set<long> yaws;
    for (const Grasp& g : grasps) {
      if (g.collides || g.type != GraspType::kCylindrical) continue;
      EXPECT_LT((g.X_CG.translation() - X_WO.translation()).head<2>().norm(), 0.003);
      yaws.insert(
          std::lround(base::ToDeg(std::atan2(g.X_CG.linear()(1, 0), g.X_CG.linear()(0, 0)))));
    }
    EXPECT_EQ(grasps.front().type, GraspType::kCylindrical);
    EXPECT_GE(yaws.size(), 8u);
    // The grasp is next to the arm, with the thumb on the arm's side.
    EXPECT_GT(
        grasps.front().X_CG.linear().col(0).dot((ArmBase() - X_WO.translation()).normalized()),
        0.0);
  }
}

TEST(PlanGrasps, HoldsACylinderOnItsAxisIfOnlyFewGraspsAreWanted) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.026, 0.06, At(0.05, 0.0));
  for (const int wanted : {1, 2, 3}) {
    GraspOptions options;
    options.max_candidates = wanted;
    const auto grasps = Plan(builder, options);
    ASSERT_FALSE(grasps.empty());
    EXPECT_EQ(grasps.front().type, GraspType::kCylindrical) << wanted;
    EXPECT_LE(std::ssize(grasps), wanted);
  }
}

TEST(PlanGrasps, AsPublishedHoldsACylinderInTheMiddleOfItsHeight) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.026, 0.06, At(0.05, 0.0));
  const auto grasps = Plan(builder, false);
  ExpectSound(builder, grasps);
  const Grasp& best = grasps.front();
  EXPECT_EQ(best.type, GraspType::kCylindrical);
  EXPECT_LT((best.X_CG.translation() - Vector3d(0.05, 0.0, 0.03)).norm(), 0.001);
  EXPECT_NEAR(best.X_CG.linear()(0, 0), -1.0, 1e-3) << "towards the arm";
}

TEST(PlanGrasps, RefusesToHoldACylinderWiderThanTheHand) {
  const auto cylindrical = [](double radius_m, bool improved) {
    SceneBuilder builder;
    builder.AddUprightCylinder(radius_m, 0.1, At(0, 0));
    const auto grasps = Plan(builder, improved);
    return std::ranges::count(grasps, GraspType::kCylindrical, &Grasp::type);
  };
  EXPECT_EQ(cylindrical(0.0495, true), 0);
  EXPECT_EQ(cylindrical(0.0495, false), 0);
  EXPECT_GT(cylindrical(0.0425, true), 0);
}

TEST(PlanGrasps, HoldsACupByItsWallToo) {
  for (const bool improved : {true, false}) {
    SceneBuilder builder;
    const base::Pose X_WO = At(0.03, -0.02);
    builder.AddCup(0.041, 0.004, 0.095, X_WO);
    const auto grasps = Plan(builder, improved);
    ExpectSound(builder, grasps);
    EXPECT_EQ(grasps.front().type, GraspType::kCylindrical);
    int rims = 0;
    bool cylindrical_before = true;
    for (const Grasp& g : grasps) {
      if (g.collides) continue;
      if (g.type == GraspType::kCylindrical) {
        EXPECT_TRUE(cylindrical_before);
      }
      if (g.type != GraspType::kRim) continue;
      cylindrical_before = false;
      ++rims;
      const auto radius = [&](const Vector3d& p_H) {
        return (g.X_CH * p_H - X_WO.translation()).head<2>().norm();
      };
      const auto& open = Hand().states[Hand().IndexAtGap(g.opening_m - 1e-6)];
      const double thumb = radius(open.thumb_pad_H);
      const double finger = radius(open.finger_pad_H);
      EXPECT_LT(std::min(thumb, finger), 0.037);
      EXPECT_GT(std::max(thumb, finger), 0.041);
      EXPECT_LT((g.X_CH * open.thumb_pad_H).z(), 0.095) << "below the rim";
      EXPECT_LT(g.X_CG.translation().x(), 0.03) << "next to the arm";
    }
    EXPECT_GE(rims, 2);
  }
}

TEST(PlanGrasps, HoldsLyingRoundObjectsAtOrBelowTheMiddle) {
  SceneBuilder lying;
  lying.AddLying(Disc(0.035), 0.115, 0.035, 0.07, 0.02, At(0, 0, 0.5));
  const auto cylinder = Plan(lying);
  ExpectSound(lying, cylinder);
  EXPECT_LT(cylinder.front().X_CG.translation().z(), 0.035 + 0.003);
  EXPECT_GT(std::abs(cylinder.front().X_CG.linear().col(0).dot(Yaw(0.5).linear().col(1))), 0.999);

  SceneBuilder half;
  half.AddLying(HalfDisc(0.04, 40), 0.17, 0.0, 0.04, 0.02, At(0, 0, 0.5));
  const auto grasps = Plan(half);
  ExpectSound(half, grasps);
  // The contact normals rise by asin(z / R), so the friction cone of 26 deg allows 17 mm.
  EXPECT_LT(grasps.front().X_CG.translation().z(), 0.0177);
}

TEST(PlanGrasps, GivesALyingPrismALowScore) {
  SceneBuilder prism, box;
  prism.AddLying({{-0.03, 0}, {0.03, 0}, {0, 0.052}}, 0.3, 0.0, 0.052, 0.01, At(0, 0));
  box.AddBox({0.3, 0.05, 0.052}, At(0, 0));
  const auto grasps = Plan(prism);
  ExpectSound(prism, grasps);
  // Faces 30 deg off the vertical are outside the friction cone of 26 deg.
  EXPECT_LT(grasps.front().score, Plan(box).front().score - 1.0);
}

/// Two walls along a box, at this distance from its long sides.
SceneBuilder BoxBetweenWalls(double distance_m, double wall_height_m = 0.12) {
  SceneBuilder builder;
  builder.AddBox({0.115, 0.06, 0.1}, At(0, 0));
  for (const double side : {-1.0, 1.0}) {
    builder.AddBox({0.3, 0.02, wall_height_m}, At(0, side * (0.03 + distance_m + 0.01)));
  }
  return builder;
}

TEST(PlanGrasps, FindsNoRoomBetweenNearWallsAndEnoughBetweenFarOnes) {
  for (const bool improved : {true, false}) {
    const auto near = Plan(BoxBetweenWalls(0.005), improved);
    ASSERT_FALSE(near.empty());
    EXPECT_EQ(Free(near), 0u);
    const auto far = Plan(BoxBetweenWalls(0.060), improved);
    EXPECT_GE(Free(far), improved ? 8u : 1u);
  }
}

// The smallest wall distance [mm] with a free grasp of the box between the walls; 80 if none.
int LeastFreeGap(const GraspOptions& options) {
  for (int mm = 10; mm < 80; mm += 2) {
    if (Free(Plan(BoxBetweenWalls(mm * base::kMm), options)) > 0) return mm;
  }
  return 80;
}

TEST(PlanGrasps, ShapesTheHandBeforeWhereTheOpenOneDoesNotFit) {
  GraspOptions options;
  options.crowded = false;
  const int shaped = LeastFreeGap(options);
  options.preshape = options.narrow_openings = false;
  EXPECT_LT(shaped, LeastFreeGap(options) - 4);
  EXPECT_GT(shaped, 20) << "the thumb's diameter";
}

// Nearby walls are lower than the box, so there is room only around its upper part.
TEST(PlanGrasps, GraspsLessDeepWhereNeighborsLeaveNoOther) {
  const auto highest_wall = [](bool crowded) {
    GraspOptions options;
    options.crowded = crowded;
    int highest = 0;
    for (int mm = 30; mm < 100; mm += 5) {
      if (Free(Plan(BoxBetweenWalls(0.005, mm * base::kMm), options)) > 0) highest = mm;
    }
    return highest;
  };
  EXPECT_GE(highest_wall(true), highest_wall(false) + 5);
}

// There is a slab above a box; the hand passes below it from the free side. Only the handling of
// crowded scenes finds this.
TEST(PlanGrasps, LeansWhereItCannotComeStraightDown) {
  SceneBuilder builder;
  builder.AddBox({0.06, 0.06, 0.12}, At(0, 0));
  builder.AddBox({0.3, 0.3, 0.02}, Move(0.0, 0.13, 0.15));
  GraspOptions options;
  EXPECT_GE(Free(Plan(builder, options)), 1u);
  options.crowded = false;
  EXPECT_EQ(Free(Plan(builder, options)), 0u);
}

GraspOptions FromTheSides() {
  GraspOptions options;
  options.approach = ApproachKind::kSides;
  return options;
}

TEST(PlanGrasps, HoldsATallObjectFromTheArmsSideClearOfTheTable) {
  for (const bool round : {true, false}) {
    SceneBuilder builder;
    if (round) {
      builder.AddUprightCylinder(0.03, 0.2, At(0, 0));
    } else {
      builder.AddBox({0.05, 0.07, 0.2}, At(0, 0));
    }
    const auto grasps = Plan(builder, FromTheSides());
    EXPECT_GE(Free(grasps), 4u);
    for (const Grasp& g : grasps) {
      if (g.collides) continue;
      const Vector3d approach = g.X_CG.linear().col(2);
      EXPECT_LT(approach.z(), 1e-9) << "level, or a little down";
      EXPECT_GT(approach.z(), -0.35);
      EXPECT_GT(approach.dot(-ArmBase()), 0.0) << "from the arm's side";
      EXPECT_NEAR(g.X_CG.linear()(2, 0), 0.0, 1e-9) << "closing";
      EXPECT_LT(g.X_CG.translation().z(), 0.19);
      for (const geometry::Shape& shape : Hand().states[Hand().IndexAtGap(g.opening_m)].shapes) {
        EXPECT_LT(geometry::Support(shape, g.X_CH, -Vector3d::UnitZ()), 0.0) << "in the table";
      }
    }
  }
}

TEST(PlanGrasps, HasNoGraspFromTheSideOfAFlatObject) {
  SceneBuilder builder;
  builder.AddBox({0.05, 0.07, 0.012}, At(0, 0));
  EXPECT_EQ(Free(Plan(builder, FromTheSides())), 0u);
}

TEST(PlanGrasps, HoldsFromTheSideNothingFarBesideItsMiddle) {
  SceneBuilder builder;
  builder.AddBox({0.25, 0.06, 0.08}, At(0, 0));
  const auto grasps = Plan(builder, FromTheSides());
  ASSERT_FALSE(grasps.empty());
  for (const Grasp& g : grasps) {
    EXPECT_LT(g.X_CG.translation().head<2>().norm(), 0.031);
  }
}

// A roof close above allows neither a vertical nor a leaning approach.
TEST(PlanGrasps, ComesFromTheSidesTooWhereAboveIsNoRoom) {
  SceneBuilder builder;
  builder.AddBox({0.05, 0.07, 0.2}, At(0, 0));
  builder.AddBox({0.6, 0.6, 0.02}, Move(0, 0, 0.25));
  GraspOptions options;
  EXPECT_EQ(Free(Plan(builder, options)), 0u);
  options.approach = ApproachKind::kSidesToo;
  EXPECT_GE(Free(Plan(builder, options)), 4u);
}

// A box stands on a wide one, and both are perceived as one object.
TEST(PlanGrasps, GripsTheUpperPartOfWhatIsTooWideFurtherDown) {
  SceneBuilder boxes;
  boxes.AddBox({0.2, 0.2, 0.06}, At(0, 0));
  boxes.AddBox({0.06, 0.08, 0.08}, Move(0, 0, 0.06));
  geometry::TriangleMesh both = boxes.scene.objects[0].surface_C;
  geometry::Append(boxes.scene.objects[1].surface_C, both);
  SceneBuilder builder;
  builder.Add(both);
  const auto grasps = Plan(builder);
  ASSERT_GE(Free(grasps), 1u);
  EXPECT_LT(grasps.front().width_m, 0.085);
  EXPECT_GT(grasps.front().X_CG.translation().z(), 0.07);
}

TEST(PlanGrasps, FallsBackToTheRimThenToThePowerGrasp) {
  // Walls around a cup, lower than its rim, leave no room for a hand outside at half height.
  SceneBuilder open;
  open.AddCup(0.0495, 0.004, 0.095, At(0, 0));
  const auto rim = Plan(open);
  ASSERT_GE(Free(rim), 1u);
  EXPECT_EQ(rim.front().type, GraspType::kRim);

  SceneBuilder closed;
  closed.AddUprightCylinder(0.0495, 0.1, At(0, 0));
  const auto power = Plan(closed);
  ASSERT_FALSE(power.empty());
  EXPECT_EQ(power.front().type, GraspType::kPower);
}

TEST(PlanGrasps, PlansPowerGraspsAloneWhereItIsTold) {
  SceneBuilder builder;
  builder.AddUprightCylinder(0.03, 0.1, At(0, 0));
  GraspOptions options;
  options.power_only = true;
  const auto grasps = Plan(builder, options);
  EXPECT_GE(Free(grasps), 1u);
  for (const Grasp& g : grasps) EXPECT_EQ(g.type, GraspType::kPower);
}

TEST(PlanGrasps, TurnsWithTheScene) {
  for (const double turn : {0.7, 2.0, -1.1}) {
    SceneBuilder here, there;
    here.AddBox({0.115, 0.06, 0.115}, At(0.05, 0.02, 0.3));
    there.AddBox({0.115, 0.06, 0.115}, Yaw(turn) * At(0.05, 0.02, 0.3));
    const auto a = Plan(here, GraspOptions{});
    const auto b = PlanGrasps(there.scene, 0, Hand(), Yaw(turn) * ArmBase(), {});
    ASSERT_EQ(a.size(), b.size());
    EXPECT_LT(((Yaw(turn) * a.front().X_CH).matrix() - b.front().X_CH.matrix()).norm(), 1e-6);
    EXPECT_NEAR(a.front().score, b.front().score, 1e-6);
  }
}

TEST(PlanGrasps, IsTheSameEveryTime) {
  SceneBuilder builder;
  builder.AddCup(0.041, 0.004, 0.095, At(0.01, 0.02));
  const auto a = Plan(builder);
  const auto b = Plan(builder);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].X_CH.matrix(), b[i].X_CH.matrix());
    EXPECT_EQ(a[i].score, b[i].score);
  }
}

TEST(PlanGrasps, NeedsNoSurface) {
  SceneBuilder builder;
  auto& object = builder.AddBox({0.115, 0.06, 0.115}, At(0, 0));
  object.surface_C = {};
  const auto grasps = Plan(builder);
  ASSERT_FALSE(grasps.empty());
  EXPECT_NEAR(std::abs(grasps.front().X_CG.linear()(1, 0)), 1.0, 0.01);
}

// The arm's shoulder, elbow and wrist span 0.6045 m; flange and hand add less than 0.5 m.
TEST(Arm, ReachesWhereTheHandIsAndNotBeyondItsLength) {
  const robot::Robot robot = robot::Robot::Load(RANGEGRASP_SOURCE_DIR "/scenes/tabletop.xml");
  const Arm arm(robot);
  base::Pose X_WH = robot.HandPose(robot.home);
  EXPECT_TRUE(arm.reaches(X_WH));
  X_WH.translation() = arm.base_C + Vector3d(1.2, 0.0, 0.3);
  EXPECT_FALSE(arm.reaches(X_WH));
}

TEST(GraspType, HasWords) {
  EXPECT_EQ(base::Word(GraspType::kCylindrical), "cylindrical");
  EXPECT_EQ(base::Word(GraspType::kRim), "rim");
  EXPECT_EQ(base::Word(GraspType::kPower), "power");
}

}  // namespace
}  // namespace rangegrasp::grasp
