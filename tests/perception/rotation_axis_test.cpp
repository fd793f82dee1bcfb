#include "perception/internal/rotation_axis.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"
#include "perception/internal/body_profile.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;

constexpr double kRadius_m = 0.04;
constexpr double kLid_m = 0.1;

Vector2d RandomCenter(base::Rng& rng) {
  const double x = rng.Uniform(-0.1, 0.1);
  return {x, rng.Uniform(-0.1, 0.1)};
}

/// A can's lid, and the part of its wall that a sensor sees (150 deg towards +x).
Analytic SeenCan(const Vector2d& center) {
  Analytic can;
  can.AddDisc({center.x(), center.y(), kLid_m}, kRadius_m);
  can.AddWall(center, kRadius_m, 0.01, 0.096, base::Deg(-75.0), base::Deg(75.0));
  return can;
}

std::optional<RotationAxis> PartAxis(const Given& given, std::uint64_t seed = 1) {
  return given.Describe(samples::All(given.cloud), seed).axis;
}

TEST(FindRotationAxis, IsExactForAnExactCan) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const Vector2d center = RandomCenter(rng);
    const Given given(SeenCan(center).cloud);
    const auto axis = PartAxis(given, seed);
    ASSERT_TRUE(axis) << seed;
    EXPECT_NEAR((axis->center_C.head<2>() - center).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->center_C.z(), kLid_m, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
    EXPECT_NEAR(axis->direction_C.z(), 1.0, 1e-12);
    EXPECT_GE(axis->rim_fraction, 0.8);
    EXPECT_EQ(axis->body_fraction, 1.0);
  }
}

TEST(FindRotationAxis, FollowsALeaningCan) {
  const Eigen::AngleAxisd lean(base::Deg(20.0), Vector3d::UnitY());
  Analytic can = SeenCan({0.0, 0.0});
  can.Turn(lean);
  const auto axis = PartAxis(Given(can.cloud));
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->direction_C - lean * Vector3d::UnitZ()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((axis->center_C - lean * Vector3d(0.0, 0.0, kLid_m)).norm(), 0.0, 1e-9);
}

TEST(FindRotationAxis, RefusesABox) {
  for (const double side : {0.02, 0.03, 0.04}) {
    Analytic box;
    box.AddRectangle({0.0, 0.0, kLid_m}, {side, 0.0, 0.0}, {0.0, side, 0.0});
    box.AddRectangle({side, 0.0, 0.05}, {0.0, side, 0.0}, {0.0, 0.0, 0.04});
    EXPECT_FALSE(PartAxis(Given(box.cloud))) << side;
  }
}

TEST(FindRotationAxis, RefusesARoundLidOnASquareBody) {
  // The first rule holds; the second does not.
  Analytic shape;
  shape.AddDisc({0.0, 0.0, kLid_m}, kRadius_m);
  for (const double x : {-kRadius_m, kRadius_m}) {
    shape.AddRectangle({x, 0.0, 0.05}, {0.0, std::copysign(kRadius_m, x), 0.0}, {0.0, 0.0, 0.04});
  }
  EXPECT_FALSE(PartAxis(Given(shape.cloud)));
}

/// The points of a disc or a ring within an angle of +x.
Indices Within(const Analytic& shape, const Indices& points, double angle_rad) {
  Indices within;
  for (const auto i : points) {
    const Vector3d& p = shape.cloud.points[i];
    if (std::abs(std::atan2(p.y(), p.x())) <= angle_rad) within.push_back(i);
  }
  return within;
}

std::optional<RotationAxis> PartAxis(const Given& given, const Indices& points) {
  return given.Describe(points).axis;
}

// Its round side makes up 61 % of its rim, and its body agrees.
TEST(FindRotationAxis, RefusesHalfALid) {
  Analytic half;
  const Indices lid = half.AddDisc({0.0, 0.0, kLid_m}, kRadius_m);
  const Indices wall = half.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.096, -1.3, 1.3);
  const Indices points = samples::Joined(Within(half, lid, 0.5 * base::kPi), wall);
  Given given(half.cloud);
  EXPECT_FALSE(PartAxis(given, points));
  given.options.axis.rim_share = 0.5;
  EXPECT_TRUE(PartAxis(given, points));
}

// An arc of 60 deg fits a circle too well to be evidence.
TEST(FindRotationAxis, RefusesAShortArc) {
  Analytic sector;
  const Indices ring = sector.AddDisc({0.0, 0.0, kLid_m}, 0.1, 0.07);
  const Indices wall = sector.AddWall({0.0, 0.0}, 0.1, 0.01, 0.096, -0.5, 0.5);
  const Indices points = samples::Joined(Within(sector, ring, 0.52), wall);
  Given given(sector.cloud);
  given.options.axis.rim_share = 0.3;
  given.options.axis_from_body = false;
  EXPECT_FALSE(PartAxis(given, points));
  given.options.axis.min_arc_rad = given.options.axis.min_body_arc_rad = 0.8;
  EXPECT_TRUE(PartAxis(given, points));
}

// If a lid leans by less than the uncertainty of its fit, the can stays upright. A can that leans
// as a whole gets a leaning axis.
TEST(FindRotationAxis, IsUprightIfTheBodyIs) {
  const Eigen::AngleAxisd lean(base::Deg(3.0), Vector3d::UnitY());
  const Vector3d top(0.0, 0.0, kLid_m);
  Analytic cut;
  const Indices lid = cut.AddDisc(top, kRadius_m);
  const Indices wall = cut.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.092, -1.3, 1.3);
  for (const auto i : lid) {
    cut.cloud.points[i] = top + lean * (cut.cloud.points[i] - top);
    cut.cloud.normals[i] = lean * cut.cloud.normals[i];
  }
  const auto upright = PartAxis(Given(cut.cloud), samples::Joined(lid, wall));
  ASSERT_TRUE(upright);
  EXPECT_EQ(upright->direction_C, Vector3d::UnitZ());
  // This is 7 mm at the can's foot, visible in the sections of an upright axis.
  const Eigen::AngleAxisd more(base::Deg(4.5), Vector3d::UnitY());
  Analytic can = SeenCan({0.0, 0.0});
  can.Turn(more);
  const auto leaning = PartAxis(Given(can.cloud));
  ASSERT_TRUE(leaning);
  EXPECT_NEAR((leaning->direction_C - more * Vector3d::UnitZ()).norm(), 0.0, 1e-9);
}

// The rim of a ring with a gap runs along its inside and outside.
TEST(FindRotationAxis, BridgesAGapInTheRim) {
  Analytic shape;
  const Indices ring = shape.AddDisc({0.0, 0.0, kLid_m}, kRadius_m, 0.03);
  const Indices wall = shape.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.096, -1.3, 1.3);
  Given given(shape.cloud);
  const auto axis = PartAxis(given, samples::Joined(Within(shape, ring, base::kPi - 0.25), wall));
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->center_C.head<2>().norm(), 0.0, 1e-6);
  EXPECT_GT(axis->rim_fraction, 0.0);
}

// The lid is 1 mm off the body's center, as happens with a rim seen at a grazing angle.
TEST(DescribePart, RefinesTheAxisByTheBody) {
  Analytic can;
  const Indices lid = can.AddDisc({0.001, 0.0, kLid_m}, kRadius_m);
  const Indices wall = can.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.096, -1.3, 1.3);
  const auto axis = PartAxis(Given(can.cloud), samples::Joined(lid, wall));
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->center_C.head<2>().norm(), 0.0, 1e-5);
}

/// A cup whose lip was seen only on the near side, so its rim gives no circle.
struct NearLip {
  Analytic cup;
  Indices points;
  explicit NearLip(double wall_rad) {
    const Indices lip = cup.AddDisc({0.0, 0.0, kLid_m}, kRadius_m, kRadius_m - 0.008);
    points = samples::Joined(Within(cup, lip, 1.6),
                             cup.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.096, -wall_rad, wall_rad));
  }
};

TEST(FindRotationAxis, OfAThinRingComesFromItsBody) {
  const NearLip lip(1.3);
  Given given(lip.cup.cloud);
  const auto axis = PartAxis(given, lip.points);
  ASSERT_TRUE(axis);
  EXPECT_EQ(axis->rim_fraction, 0.0);
  EXPECT_NEAR((axis->center_C - Vector3d(0.0, 0.0, kLid_m)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
  given.options.axis_from_body = false;
  EXPECT_FALSE(PartAxis(given, lip.points));
  const NearLip narrow(0.8);  // 92 deg of wall
  EXPECT_FALSE(PartAxis(Given(narrow.cup.cloud), narrow.points));
}

TEST(FindRotationAxis, OfAThinRingAllowsAHandle) {
  NearLip lip(1.3);
  const Indices handle = lip.cup.AddWall({0.0, 0.0}, 0.06, 0.02, 0.086, -0.5, 0.5);
  const Indices points = samples::Joined(lip.points, handle);
  const auto axis = PartAxis(Given(lip.cup.cloud), points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
  EXPECT_LT(axis->body_fraction, 0.8);  // too few for an axis from a rim
}

// At the outline of the seen part, normals are turned towards the sensor; distances stay correct.
TEST(FindRotationAxis, AllowsTurnedNormalsAtTheOutline) {
  for (const auto& [share, found] : {std::pair(0.3, true), std::pair(0.45, false)}) {
    Analytic can = SeenCan({0.0, 0.0});
    const double inner = base::Deg(75.0) * (1.0 - share);
    for (std::size_t i = 0; i < can.cloud.size(); ++i) {
      Vector3d& n = can.cloud.normals[i];
      const double angle = std::atan2(n.y(), n.x());
      if (n.z() > 0.5 || std::abs(angle) < inner) continue;
      n = Eigen::AngleAxisd(std::copysign(base::Deg(25.0), -angle), Vector3d::UnitZ()) * n;
    }
    EXPECT_EQ(PartAxis(Given(can.cloud)).has_value(), found) << share;
  }
}

// A fifth of the lid is missing because of gloss, so the rim runs through the hole.
TEST(FindRotationAxis, OfALidWithAHoleComesFromTheWall) {
  Analytic can;
  const Indices lid = can.AddDisc({0.0, 0.0, kLid_m}, kRadius_m);
  Indices points = can.AddWall({0.0, 0.0}, kRadius_m, 0.01, 0.096, -1.3, 1.3);
  for (const auto i : lid) {
    if (can.cloud.points[i].x() > -0.5 * kRadius_m) points.push_back(i);
  }
  Given given(can.cloud);
  const auto axis = PartAxis(given, points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-6);
  given.options.axis_from_body = false;
  given.options.axis.rim_share = 0.95;
  EXPECT_FALSE(PartAxis(given, points));
}

// The narrow side of a bottle under its round cap is round, but only over a short arc.
TEST(FindRotationAxis, RefusesARoundCapOnANarrowArc) {
  Analytic bottle;
  const Indices cap = bottle.AddDisc({0.0, 0.0, kLid_m}, 0.014);
  const Indices side = bottle.AddWall({0.0, 0.0}, 0.045, 0.01, 0.09, -0.5, 0.5);
  Given given(bottle.cloud);
  EXPECT_FALSE(PartAxis(given, samples::Joined(cap, side)));
  given.options.axis.min_body_arc_rad = 0.0;  // as published
  EXPECT_TRUE(PartAxis(given, samples::Joined(cap, side)));
}

// The floor of a bowl has more points than its lip.
TEST(FindRotationAxis, OfABowlComesFromItsLip) {
  Analytic bowl;
  const Indices lip = bowl.AddDisc({0.0, 0.0, kLid_m}, 0.08, 0.075);
  const Indices wall = bowl.AddWall({0.0, 0.0}, 0.08, 0.06, 0.098, -1.3, 1.3);
  Indices points = samples::Joined(lip, wall);
  for (const auto i : bowl.AddDisc({0.0, 0.0, 0.05}, 0.06)) {
    if (bowl.cloud.points[i].x() < 0.0) points.push_back(i);  // the near wall hides the rest
  }
  Given given(bowl.cloud);
  given.options.top_plane_share = 1.0;
  const auto axis = PartAxis(given, points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->center_C - Vector3d(0.0, 0.0, kLid_m)).norm(), 0.0, 1e-6);
  given.options.lip_tops = false;
  EXPECT_FALSE(PartAxis(given, points));
}

TEST(ShareOnCircle, CountsWhatIsWithinTheDistance) {
  Analytic shape;
  const Circle circle{{0.0, 0.0, 0.0}, Vector3d::UnitZ(), 0.05};
  Indices points;
  for (const Vector3d& p : {Vector3d(0.0519, 0.0, 0.0), Vector3d(0.0, 0.0481, 0.0019),
                            Vector3d(0.0521, 0.0, 0.0), Vector3d(0.05, 0.0, 0.0021)}) {
    points.push_back(shape.Add(p, Vector3d::UnitZ()));
  }
  EXPECT_EQ(ShareOnCircle(shape.cloud, points, circle, 0.002), 0.5);
  EXPECT_EQ(ShareOnCircle(shape.cloud, {}, circle, 0.002), 0.0);
}

TEST(RefineAxis, MovesAnAxisThatTheRimPutWrongBackToTheBody) {
  const Given given(SeenCan({0.0, 0.0}).cloud);
  const auto part = given.Describe(samples::All(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.0008, -0.0006, 0.0);
  axis.radius_m -= 0.0007;
  RefineAxis(given.Context(), part.points, *part.top, axis);
  // Gauss-Newton, started 1 mm off for 40 mm, converges at least by (1 / 40) per iteration.
  EXPECT_NEAR(axis.center_C.head<2>().norm(), 0.0, 1e-6);
  EXPECT_NEAR(axis.radius_m, kRadius_m, 1e-6);
}

TEST(RefineAxis, LeavesAnAxisThatIsFurtherOffThanARimCanBe) {
  const Given given(SeenCan({0.0, 0.0}).cloud);
  const auto part = given.Describe(samples::All(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.006, 0.0, 0.0);
  const RotationAxis before = axis;
  RefineAxis(given.Context(), part.points, *part.top, axis);
  EXPECT_EQ(axis.center_C, before.center_C);
}

TEST(ArcOf, CountsAPointInEveryDirection) {
  const Circle circle{Vector3d::Zero(), Vector3d::UnitZ(), 0.05};
  const Vector3d u = circle.normal.unitOrthogonal();  // where the bins begin and end
  for (const Vector3d& direction : {u, Vector3d(-u), Vector3d(circle.normal.cross(u))}) {
    Analytic one;
    one.Add(0.05 * direction, direction);
    EXPECT_NEAR(ArcOf(one.cloud, {0}, circle), base::Deg(10.0), 1e-9) << direction.transpose();
  }
}

TEST(ArcOf, CountsHowFarRoundPointsGo) {
  for (const double degrees : {30.0, 120.0, 250.0, 360.0}) {
    Analytic arc;
    const Indices points = arc.AddWall({0.01, 0.02}, 0.05, 0.0, 0.002, 0.0, base::Deg(degrees));
    const Circle circle{{0.01, 0.02, 0.0}, Vector3d::UnitZ(), 0.05};
    // Bins are 10 deg wide, so there can be one more at either end.
    EXPECT_NEAR(ArcOf(arc.cloud, points, circle), base::Deg(degrees), base::Deg(20.0));
  }
}

constexpr double kLyingAxisRadius_m = 0.035;
constexpr double kLength_m = 0.115;

/// A cylinder on the table along `yaw`, seen from the angle `from` to `to` about its axis (0 is
/// up), with the end that faces +x.
Analytic LyingCylinder(double yaw, double from_rad, double to_rad,
                       double height_m = kLyingAxisRadius_m) {
  Analytic shape;
  const Vector3d along(std::cos(yaw), std::sin(yaw), 0.0);
  const Vector3d across(-std::sin(yaw), std::cos(yaw), 0.0);
  const Vector3d center(0.02, -0.03, height_m);
  const int around = static_cast<int>((to_rad - from_rad) * kLyingAxisRadius_m / samples::kStep_m);
  const int rows = static_cast<int>(std::lround(kLength_m / samples::kStep_m));
  for (int row = 0; row <= rows; ++row) {
    for (int k = 0; k <= around; ++k) {
      const double a = from_rad + (to_rad - from_rad) * k / around;
      const Vector3d out = std::sin(a) * across + std::cos(a) * Vector3d::UnitZ();
      shape.Add(center + (static_cast<double>(row) / rows - 0.5) * kLength_m * along +
                    kLyingAxisRadius_m * out,
                out);
    }
  }
  for (double r = kLyingAxisRadius_m - samples::kStep_m; r > 0.0; r -= samples::kStep_m) {
    const int ring = static_cast<int>(2.0 * base::kPi * r / samples::kStep_m);
    for (int k = 0; k < ring; ++k) {
      const double a = 2.0 * base::kPi * k / ring;
      shape.Add(center + 0.5 * kLength_m * along +
                    r * (std::cos(a) * across + std::sin(a) * Vector3d::UnitZ()),
                along);
    }
  }
  return shape;
}

std::optional<RotationAxis> AxisOf(const Given& given, std::uint64_t seed = 1) {
  base::Rng rng(seed);
  return FindLyingAxis(given.Context(), samples::All(given.cloud), rng);
}

TEST(FindLyingAxis, IsThatOfTheCylinderWhateverItsYaw) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double yaw = 0.3 * static_cast<double>(seed);
    const auto axis = AxisOf(Given(LyingCylinder(yaw, -0.6, 1.7).cloud), seed);
    ASSERT_TRUE(axis) << seed;
    const Vector3d along(std::cos(yaw), std::sin(yaw), 0.0);
    EXPECT_NEAR(std::abs(axis->direction_C.dot(along)), 1.0, 1e-9);
    EXPECT_NEAR(axis->radius_m, kLyingAxisRadius_m, 1e-9);
    // Each end is at the fifth outermost point, which is in the same row.
    EXPECT_NEAR(axis->length_m, kLength_m, 1e-9);
    const Vector3d middle = axis->center_C - 0.5 * axis->length_m * axis->direction_C;
    EXPECT_NEAR((middle - Vector3d(0.02, -0.03, kLyingAxisRadius_m)).norm(), 0.0, 1e-9);
  }
}

// For a body on the table, the table determines the width; in the air, the arc must.
TEST(FindLyingAxis, IsFoundOnSomethingElseThanTheTable) {
  const auto axis = AxisOf(Given(LyingCylinder(0.4, -0.6, 1.7, 0.1).cloud));
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kLyingAxisRadius_m, 1e-6);
}

TEST(FindLyingAxis, NeedsAnArc) {
  EXPECT_FALSE(AxisOf(Given(LyingCylinder(0.4, -0.3, 0.8).cloud)));  // 63 deg
}

TEST(FindLyingAxis, IsNoneOfABoxOrOfHalfACylinder) {
  for (const double yaw : {0.0, 0.5, 1.1}) {
    Analytic box;
    box.AddRectangle({0, 0, 0.05}, {0.06, 0, 0}, {0, 0.025, 0});
    box.AddRectangle({0, 0.025, 0.027}, {-0.06, 0, 0}, {0, 0, 0.023});
    box.Turn(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    EXPECT_FALSE(AxisOf(Given(box.cloud))) << yaw;
  }
  // On its flat side, the circle would be below the table.
  EXPECT_FALSE(AxisOf(Given(LyingCylinder(0.4, -1.2, 1.5, 0.0).cloud)));
}

TEST(FindLyingAxis, IsAPartsWhereNothingStandsAndCanBeSwitchedOff) {
  Given given(LyingCylinder(0.4, -0.6, 1.7).cloud);
  const Indices all = samples::All(given.cloud);
  const auto part = given.Describe(all);
  ASSERT_TRUE(part.axis);
  EXPECT_TRUE(part.axis->Lies());
  given.options.lying_axes = false;
  EXPECT_FALSE(given.Describe(all).axis);
}

/// A cup about (0.02, -0.03): its lip, the outside of its near wall and the inside of its far wall.
Indices AddCup(Analytic& shape, double wall_m) {
  const Vector2d center(0.02, -0.03);
  const auto lip = shape.AddDisc({0.02, -0.03, 0.1}, kRadius_m, kRadius_m - wall_m);
  const auto outside =
      shape.AddWall(center, kRadius_m, 0.01, 0.096, base::Deg(-75.0), base::Deg(75.0));
  const auto inside = shape.AddWall(center, kRadius_m - wall_m, 0.05, 0.096, base::Deg(105.0),
                                    base::Deg(255.0), true);
  return samples::Joined(samples::Joined(lip, outside), inside);
}

TEST(AxisFromBody, IsExactForAnExactWallWhateverTheDraws) {
  Analytic cup;
  const Indices points = AddCup(cup, 0.004);
  const Given given(cup.cloud);
  const Part part = given.Describe(points);
  ASSERT_TRUE(part.top);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const auto axis = AxisFromBody(given.Context(), part.points, *part.top, rng);
    ASSERT_TRUE(axis);
    EXPECT_NEAR((axis->center_C - Vector3d(0.02, -0.03, 0.1)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
    EXPECT_EQ(axis->direction_C, Vector3d::UnitZ());
  }
}

// These are not part of the wall: the inside of a wall of 1.5 mm, a handle, points 1.5 mm off whose
// normals do not pass through the axis, and the rounding of the lip.
TEST(AxisFromBody, TakesWhatFacesOutwardOnTheCircleAlone) {
  Analytic cup;
  Indices points = AddCup(cup, 0.0015);
  const Vector2d center(0.02, -0.03);
  const auto handle = cup.AddWall(center, 0.055, 0.03, 0.08, 0.0, 0.4);
  const auto turned = cup.AddWall(center, kRadius_m + 0.0015, 0.03, 0.08, -0.5, 0.5);
  for (const auto i : turned) {
    cup.cloud.normals[i] =
        Eigen::AngleAxisd(base::Deg(50.0), Vector3d::UnitZ()) * cup.cloud.normals[i];
  }
  const auto rounding = cup.AddWall(center, kRadius_m + 0.0015, 0.09, 0.096, -1.3, 1.3);
  for (const auto i : rounding) {
    cup.cloud.normals[i] = (cup.cloud.normals[i] + 2.0 * Vector3d::UnitZ()).normalized();
  }
  for (const auto& more : {handle, turned, rounding}) points = samples::Joined(points, more);
  const Given given(cup.cloud);
  TopSurface top;
  top.center_C = {0.02, -0.03, 0.1};
  base::Rng rng(1);
  const auto axis = AxisFromBody(given.Context(), points, top, rng);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->center_C - top.center_C).head<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
}

TEST(AxisFromBody, NeedsAWallOfSixtyPointsThatIsNoWiderThanATabletopObject) {
  const auto found = [](double radius_m, std::size_t count) {
    Analytic wall;
    Indices points = wall.AddWall({0.0, 0.0}, radius_m, 0.05, 0.06, -0.6, 0.6);
    EXPECT_GE(points.size(), count);
    points.resize(count);
    const Given given(wall.cloud);
    TopSurface top;
    top.center_C = {0.0, 0.0, 0.1};
    base::Rng rng(1);
    return AxisFromBody(given.Context(), points, top, rng).has_value();
  };
  EXPECT_FALSE(found(0.05, 59));
  EXPECT_TRUE(found(0.05, 60));
  EXPECT_TRUE(found(0.14, 300));
  EXPECT_FALSE(found(0.16, 300));
}

TEST(AxisFromBody, RefusesFlatWalls) {
  Analytic box;
  const Indices points =
      samples::Joined(box.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}),
                      box.AddRectangle({0.03, 0.0, 0.05}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.04}));
  const Given given(box.cloud);
  const Part part = given.Describe(points);
  base::Rng rng(1);
  EXPECT_FALSE(AxisFromBody(given.Context(), part.points, *part.top, rng));
}

TEST(IsThinRing, EveryConditionCounts) {
  const auto thin = [](double wall_m, double radius_m, const FeatureOptions& options) {
    Analytic ring;
    TopSurface top;
    top.plane = {Vector3d::UnitZ(), -0.1};
    top.center_C = {0.0, 0.0, 0.1};
    top.points = ring.AddDisc(top.center_C, kRadius_m, kRadius_m - wall_m);
    const RotationAxis axis{top.center_C, Vector3d::UnitZ(), radius_m, 0.0, 0.0};
    return IsThinRing(Given(ring.cloud, options).Context(), top, axis);
  };
  EXPECT_TRUE(thin(0.004, kRadius_m, {}));
  EXPECT_FALSE(thin(0.004, 0.03, {}));  // outside of the circle
  FeatureOptions any_area;
  any_area.axis.ring_share = 10.0;
  EXPECT_FALSE(thin(0.016, kRadius_m, any_area));  // wider than a wall
  FeatureOptions any_wall;
  any_wall.axis.max_wall_m = 1.0;
  EXPECT_FALSE(thin(0.016, kRadius_m, any_wall));  // fills 64 % of the circle
}

TEST(IsThinRing, IsALipAndNotALid) {
  const RotationAxis axis{{0.02, -0.03, 0.1}, Vector3d::UnitZ(), kRadius_m, 0.0, 0.0};
  // A wall of thickness w fills 1 - (1 - w / r)^2 of the circle: 0.19 for 4 mm, everything for a
  // lid. A wall is at most 10 mm thick.
  for (const auto& [wall, thin] : {std::pair(0.004, true), {0.016, false}, {0.04, false}}) {
    Analytic cup;
    AddCup(cup, wall);
    const Given given(cup.cloud);
    TopSurface top;
    top.plane = {Vector3d::UnitZ(), -0.1};
    top.center_C = axis.center_C;
    for (std::uint32_t i = 0; i < cup.cloud.size(); ++i) {
      if (cup.cloud.points[i].z() == 0.1) top.points.push_back(i);
    }
    EXPECT_EQ(IsThinRing(given.Context(), top, axis), thin) << wall;
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
