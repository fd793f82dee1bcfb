#include "perception/internal/rotation_axis.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"
#include "perception/internal/axis_refinement.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;

constexpr double kRotationAxisRadius_m = 0.04;
constexpr double kRotationAxisHeight_m = 0.1;

Vector2d RandomCenter(base::Rng& rng) {
  const double x = rng.Uniform(-0.1, 0.1);
  return {x, rng.Uniform(-0.1, 0.1)};
}

/// A can's lid, and its wall as far round as a sensor sees it (150 deg towards +x).
Analytic RotationAxisCan(const Vector2d& center) {
  Analytic can;
  can.AddDisc({center.x(), center.y(), kRotationAxisHeight_m}, kRotationAxisRadius_m);
  can.AddWall(center, kRotationAxisRadius_m, 0.01, 0.096, base::Deg(-75.0), base::Deg(75.0));
  return can;
}

Indices RotationAxisAll(const geometry::PointCloud& cloud) {
  Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

std::optional<RotationAxis> RotationAxisAxisOf(const Given& given, std::uint64_t seed) {
  return given.Describe(RotationAxisAll(given.cloud), seed).axis;
}

TEST(FindRotationAxis, IsExactForAnExactCan) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const Vector2d center = RandomCenter(rng);
    const Given given(RotationAxisCan(center).cloud);
    const auto axis = RotationAxisAxisOf(given, seed);
    ASSERT_TRUE(axis) << seed;
    EXPECT_NEAR((axis->center_C.head<2>() - center).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->center_C.z(), kRotationAxisHeight_m, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRotationAxisRadius_m, 1e-9);
    EXPECT_NEAR(axis->direction_C.z(), 1.0, 1e-12);
    EXPECT_GE(axis->rim_fraction, 0.8);
    EXPECT_EQ(axis->body_fraction, 1.0);
  }
}

TEST(FindRotationAxis, FollowsALeaningCan) {
  const Eigen::AngleAxisd lean(base::Deg(20.0), Vector3d::UnitY());
  auto cloud = RotationAxisCan({0.0, 0.0}).cloud;
  for (Vector3d& p : cloud.points) p = lean * p;
  for (Vector3d& n : cloud.normals) n = lean * n;
  const auto axis = RotationAxisAxisOf(Given(cloud), 1);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->direction_C - lean * Vector3d::UnitZ()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((axis->center_C - lean * Vector3d(0.0, 0.0, kRotationAxisHeight_m)).norm(), 0.0,
              1e-9);
}

TEST(FindRotationAxis, RefusesABox) {
  for (const double side : {0.02, 0.03, 0.04}) {
    Analytic box;
    box.AddRectangle({0.0, 0.0, kRotationAxisHeight_m}, {side, 0.0, 0.0}, {0.0, side, 0.0});
    box.AddRectangle({side, 0.0, 0.05}, {0.0, side, 0.0}, {0.0, 0.0, 0.04});
    EXPECT_FALSE(RotationAxisAxisOf(Given(box.cloud), 1)) << side;
  }
}

TEST(FindRotationAxis, RefusesARoundLidOnASquareBody) {
  // The first rule holds, the second does not.
  Analytic shape;
  shape.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m);
  for (const double x : {-kRotationAxisRadius_m, kRotationAxisRadius_m}) {
    shape.AddRectangle({x, 0.0, 0.05}, {0.0, std::copysign(kRotationAxisRadius_m, x), 0.0},
                       {0.0, 0.0, 0.04});
  }
  EXPECT_FALSE(RotationAxisAxisOf(Given(shape.cloud), 1));
}

/// The parts of a disc, or of a ring, within an angle of +x.
Indices Within(const Analytic& shape, const Indices& points, double angle_rad) {
  Indices within;
  for (const auto i : points) {
    const Vector3d& p = shape.cloud.points[i];
    if (std::abs(std::atan2(p.y(), p.x())) <= angle_rad) within.push_back(i);
  }
  return within;
}

std::optional<RotationAxis> RotationAxisAxisOf(const Given& given, const Indices& points) {
  return given.Describe(points).axis;
}

// Its round side is 61 % of its rim, and its body agrees.
TEST(FindRotationAxis, RefusesHalfALid) {
  Analytic half;
  const Indices lid = half.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m);
  const Indices wall = half.AddWall({0.0, 0.0}, kRotationAxisRadius_m, 0.01, 0.096, -1.3, 1.3);
  const Indices points = samples::Joined(Within(half, lid, 0.5 * base::kPi), wall);
  Given given(half.cloud);
  EXPECT_FALSE(RotationAxisAxisOf(given, points));
  given.options.axis.rim_share = 0.5;
  EXPECT_TRUE(RotationAxisAxisOf(given, points));
}

// An arc of 60 deg fits too well to say anything.
TEST(FindRotationAxis, RefusesAShortArc) {
  Analytic sector;
  const Indices ring = sector.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, 0.1, 0.07);
  const Indices wall = sector.AddWall({0.0, 0.0}, 0.1, 0.01, 0.096, -0.5, 0.5);
  const Indices points = samples::Joined(Within(sector, ring, 0.52), wall);
  Given given(sector.cloud);
  given.options.axis.rim_share = 0.3;
  given.options.axis_from_body = false;
  EXPECT_FALSE(RotationAxisAxisOf(given, points));
  given.options.axis.min_arc_rad = given.options.axis.min_body_arc_rad = 0.8;
  EXPECT_TRUE(RotationAxisAxisOf(given, points));
}

// A lid that leans by less than its fit is uncertain is no reason to lean the whole can; a can that
// leans as a whole does.
TEST(FindRotationAxis, IsUprightIfTheBodyIs) {
  const Eigen::AngleAxisd lean(base::Deg(3.0), Vector3d::UnitY());
  const Vector3d top(0.0, 0.0, kRotationAxisHeight_m);
  Analytic cut;
  const Indices lid = cut.AddDisc(top, kRotationAxisRadius_m);
  const Indices wall = cut.AddWall({0.0, 0.0}, kRotationAxisRadius_m, 0.01, 0.092, -1.3, 1.3);
  for (const auto i : lid) {
    cut.cloud.points[i] = top + lean * (cut.cloud.points[i] - top);
    cut.cloud.normals[i] = lean * cut.cloud.normals[i];
  }
  const auto upright = RotationAxisAxisOf(Given(cut.cloud), samples::Joined(lid, wall));
  ASSERT_TRUE(upright);
  EXPECT_EQ(upright->direction_C, Vector3d::UnitZ());
  // 7 mm at the can's foot, which the sections of an upright axis show.
  const Eigen::AngleAxisd more(base::Deg(4.5), Vector3d::UnitY());
  auto cloud = RotationAxisCan({0.0, 0.0}).cloud;
  for (Vector3d& p : cloud.points) p = more * p;
  for (Vector3d& n : cloud.normals) n = more * n;
  const auto leaning = RotationAxisAxisOf(Given(cloud), 1);
  ASSERT_TRUE(leaning);
  EXPECT_NEAR((leaning->direction_C - more * Vector3d::UnitZ()).norm(), 0.0, 1e-9);
}

// The rim of a ring with a gap runs inside and out.
TEST(FindRotationAxis, BridgesAGapInTheRim) {
  Analytic shape;
  const Indices ring =
      shape.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m, 0.03);
  const Indices wall = shape.AddWall({0.0, 0.0}, kRotationAxisRadius_m, 0.01, 0.096, -1.3, 1.3);
  Given given(shape.cloud);
  const auto axis =
      RotationAxisAxisOf(given, samples::Joined(Within(shape, ring, base::kPi - 0.25), wall));
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->center_C.head<2>().norm(), 0.0, 1e-6);
  EXPECT_GT(axis->rim_fraction, 0.0);
}

// The lid lies 1 mm beside the body's middle, as a rim seen at a grazing angle does.
TEST(FindRotationAxis, IsRefinedByTheBody) {
  Analytic can;
  const Indices lid = can.AddDisc({0.001, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m);
  const Indices wall = can.AddWall({0.0, 0.0}, kRotationAxisRadius_m, 0.01, 0.096, -1.3, 1.3);
  const auto axis = RotationAxisAxisOf(Given(can.cloud), samples::Joined(lid, wall));
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->center_C.head<2>().norm(), 0.0, 1e-5);
}

/// A cup of which the lip was seen on the near side alone: its rim gives no circle.
struct NearLip {
  Analytic cup;
  Indices points;
  explicit NearLip(double wall_rad) {
    const Indices lip = cup.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m,
                                    kRotationAxisRadius_m - 0.008);
    points = samples::Joined(Within(cup, lip, 1.6), cup.AddWall({0.0, 0.0}, kRotationAxisRadius_m,
                                                                0.01, 0.096, -wall_rad, wall_rad));
  }
};

TEST(FindRotationAxis, OfAThinRingComesFromItsBody) {
  const NearLip lip(1.3);
  Given given(lip.cup.cloud);
  const auto axis = RotationAxisAxisOf(given, lip.points);
  ASSERT_TRUE(axis);
  EXPECT_EQ(axis->rim_fraction, 0.0);
  EXPECT_NEAR((axis->center_C - Vector3d(0.0, 0.0, kRotationAxisHeight_m)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(axis->radius_m, kRotationAxisRadius_m, 1e-9);
  given.options.axis_from_body = false;
  EXPECT_FALSE(RotationAxisAxisOf(given, lip.points));
  const NearLip narrow(0.8);  // 92 deg of wall
  EXPECT_FALSE(RotationAxisAxisOf(Given(narrow.cup.cloud), narrow.points));
}

TEST(FindRotationAxis, OfAThinRingAllowsAHandle) {
  NearLip lip(1.3);
  const Indices handle = lip.cup.AddWall({0.0, 0.0}, 0.06, 0.02, 0.086, -0.5, 0.5);
  const Indices points = samples::Joined(lip.points, handle);
  const auto axis = RotationAxisAxisOf(Given(lip.cup.cloud), points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kRotationAxisRadius_m, 1e-9);
  EXPECT_LT(axis->body_fraction, 0.8);  // of a rim's axis that would be too few
}

// At the outline of what is seen normals are turned towards the sensor; distances are not.
TEST(FindRotationAxis, AllowsTurnedNormalsAtTheOutline) {
  for (const auto& [share, found] : {std::pair(0.3, true), std::pair(0.45, false)}) {
    Analytic can = RotationAxisCan({0.0, 0.0});
    const double inner = base::Deg(75.0) * (1.0 - share);
    for (std::size_t i = 0; i < can.cloud.size(); ++i) {
      Vector3d& n = can.cloud.normals[i];
      const double angle = std::atan2(n.y(), n.x());
      if (n.z() > 0.5 || std::abs(angle) < inner) continue;
      n = Eigen::AngleAxisd(std::copysign(base::Deg(25.0), -angle), Vector3d::UnitZ()) * n;
    }
    EXPECT_EQ(RotationAxisAxisOf(Given(can.cloud), 1).has_value(), found) << share;
  }
}

// Gloss has taken a fifth of the lid away: the rim runs through the hole.
TEST(FindRotationAxis, OfALidWithAHoleComesFromTheWall) {
  Analytic can;
  const Indices lid = can.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, kRotationAxisRadius_m);
  Indices points = can.AddWall({0.0, 0.0}, kRotationAxisRadius_m, 0.01, 0.096, -1.3, 1.3);
  for (const auto i : lid) {
    if (can.cloud.points[i].x() > -0.5 * kRotationAxisRadius_m) points.push_back(i);
  }
  Given given(can.cloud);
  const auto axis = RotationAxisAxisOf(given, points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kRotationAxisRadius_m, 1e-6);
  given.options.axis_from_body = false;
  given.options.axis.rim_share = 0.95;
  EXPECT_FALSE(RotationAxisAxisOf(given, points));
}

// The narrow side of a bottle is round under its round cap, but not far round.
TEST(FindRotationAxis, RefusesARoundCapOnANarrowArc) {
  Analytic bottle;
  const Indices cap = bottle.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, 0.014);
  const Indices side = bottle.AddWall({0.0, 0.0}, 0.045, 0.01, 0.09, -0.5, 0.5);
  Given given(bottle.cloud);
  EXPECT_FALSE(RotationAxisAxisOf(given, samples::Joined(cap, side)));
  given.options.axis.min_body_arc_rad = 0.0;  // as published
  EXPECT_TRUE(RotationAxisAxisOf(given, samples::Joined(cap, side)));
}

// The floor of a bowl holds more points than its lip.
TEST(FindRotationAxis, OfABowlComesFromItsLip) {
  Analytic bowl;
  const Indices lip = bowl.AddDisc({0.0, 0.0, kRotationAxisHeight_m}, 0.08, 0.075);
  const Indices wall = bowl.AddWall({0.0, 0.0}, 0.08, 0.06, 0.098, -1.3, 1.3);
  Indices points = samples::Joined(lip, wall);
  for (const auto i : bowl.AddDisc({0.0, 0.0, 0.05}, 0.06)) {
    if (bowl.cloud.points[i].x() < 0.0) points.push_back(i);  // The near wall hides the rest.
  }
  Given given(bowl.cloud);
  given.options.top_plane_share = 1.0;
  const auto axis = RotationAxisAxisOf(given, points);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->center_C - Vector3d(0.0, 0.0, kRotationAxisHeight_m)).norm(), 0.0, 1e-6);
  given.options.lip_tops = false;
  EXPECT_FALSE(RotationAxisAxisOf(given, points));
}

TEST(ShareOnCircle, CountsWhatIsWithinTheDistance) {
  Analytic shape;
  const Circle circle{{0.0, 0.0, 0.0}, Vector3d::UnitZ(), 0.05};
  Indices points;
  for (const Vector3d& p : {Vector3d(0.0519, 0.0, 0.0), Vector3d(0.0, 0.0481, 0.0019),
                            Vector3d(0.0521, 0.0, 0.0), Vector3d(0.05, 0.0, 0.0021)}) {
    points.push_back(static_cast<std::uint32_t>(shape.cloud.size()));
    shape.Add(p, Vector3d::UnitZ());
  }
  EXPECT_EQ(ShareOnCircle(shape.cloud, points, circle, 0.002), 0.5);
  EXPECT_EQ(ShareOnCircle(shape.cloud, {}, circle, 0.002), 0.0);
}

TEST(RefineAxis, MovesAnAxisThatTheRimPutWrongBackToTheBody) {
  const Given given(RotationAxisCan({0.0, 0.0}).cloud);
  const auto part = given.Describe(RotationAxisAll(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.0008, -0.0006, 0.0);
  axis.radius_m -= 0.0007;
  RefineAxis(given.cloud, part.points, *part.top, given.options, axis);
  // Gauss-Newton from 1 mm off 40 mm converges by (1 / 40) a round at the slowest.
  EXPECT_NEAR(axis.center_C.head<2>().norm(), 0.0, 1e-6);
  EXPECT_NEAR(axis.radius_m, kRotationAxisRadius_m, 1e-6);
}

TEST(RefineAxis, LeavesAnAxisThatIsFurtherOffThanARimCanBe) {
  const Given given(RotationAxisCan({0.0, 0.0}).cloud);
  const auto part = given.Describe(RotationAxisAll(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.006, 0.0, 0.0);
  const RotationAxis before = axis;
  RefineAxis(given.cloud, part.points, *part.top, given.options, axis);
  EXPECT_EQ(axis.center_C, before.center_C);
}

TEST(ArcOf, CountsHowFarRoundPointsGo) {
  for (const double degrees : {30.0, 120.0, 250.0, 360.0}) {
    Analytic arc;
    const Indices points = arc.AddWall({0.01, 0.02}, 0.05, 0.0, 0.002, 0.0, base::Deg(degrees));
    const Circle circle{{0.01, 0.02, 0.0}, Vector3d::UnitZ(), 0.05};
    // Bins of 10 deg: up to one more at either end.
    EXPECT_NEAR(ArcOf(arc.cloud, points, circle), base::Deg(degrees), base::Deg(20.0));
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
