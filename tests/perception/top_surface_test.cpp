#include "perception/internal/top_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "geometry/random_points.h"
#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;

constexpr double kAlpha_m = 0.006;

double TwiceArea(const geometry::PointCloud& cloud, const Indices& loop) {
  double twice = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3d& a = cloud.points[loop[i]];
    const Vector3d& b = cloud.points[loop[(i + 1) % loop.size()]];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice;
}

Indices OuterRim(const geometry::PointCloud& cloud, const Indices& points,
                 const geometry::Plane& plane, double alpha_m) {
  return OuterRims(cloud, points, plane, {&alpha_m, 1}).front();
}

TEST(OuterRims, OfAGridIsItsBorderInOrder) {
  Analytic shape;
  const Indices points =
      shape.AddRectangle({0.1, 0.2, 0.05}, {0.03, 0.0, 0.0}, {0.0, 0.02, 0.0});  // 31 x 21
  const Indices rim = OuterRim(shape.cloud, points, samples::LevelAt(0.05), kAlpha_m);
  EXPECT_EQ(std::set(rim.begin(), rim.end()).size(), 2u * (30u + 20u));
  EXPECT_EQ(rim.size(), 2u * (30u + 20u));
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Vector3d d = shape.cloud.points[rim[i]] - Vector3d(0.1, 0.2, 0.05);
    EXPECT_NEAR(std::max(std::abs(d.x()) / 0.03, std::abs(d.y()) / 0.02), 1.0, 1e-9);
    const Vector3d& next = shape.cloud.points[rim[(i + 1) % rim.size()]];
    EXPECT_NEAR((next - shape.cloud.points[rim[i]]).norm(), samples::kStep_m, 1e-9);
  }
  EXPECT_NEAR(TwiceArea(shape.cloud, rim), 2.0 * 0.06 * 0.04, 1e-9);
}

TEST(OuterRims, OfARingIsItsOuterCircleAlone) {
  Analytic ring;
  const Indices points = ring.AddDisc({0.0, 0.0, 0.08}, 0.04, 0.03);
  const Indices rim = OuterRim(ring.cloud, points, samples::LevelAt(0.08), kAlpha_m);
  EXPECT_GE(rim.size(), 125u);  // 2 pi 40 mm / 2 mm
  for (const auto i : rim) EXPECT_NEAR(ring.cloud.points[i].head<2>().norm(), 0.04, 1e-9);
}

TEST(OuterRims, BridgesGapsWithAWiderAlpha) {
  // A thin ring with a gap of 20 mm; without bridging, its rim runs along the inside and outside.
  Analytic ring;
  const Indices points = ring.AddWall({0.0, 0.0}, 0.04, 0.08, 0.082, 0.0, 2.0 * base::kPi - 0.5);
  const Indices more = ring.AddWall({0.0, 0.0}, 0.038, 0.08, 0.082, 0.0, 2.0 * base::kPi - 0.5);
  const Indices all = samples::Joined(points, more);
  const std::array<double, 2> alphas_m{kAlpha_m, 0.030};
  const auto rims = OuterRims(ring.cloud, all, samples::LevelAt(0.081), alphas_m);
  EXPECT_GT(rims[0].size(), points.size() * 9 / 5);
  EXPECT_LT(rims[1].size(), 1.2 * static_cast<double>(points.size()));
}

TEST(OuterRims, OfPointsTooFarApartIsTheirHull) {
  Analytic corners;
  for (const auto& [x, y] :
       {std::pair(0.0, 0.0), {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}, {0.05, 0.04}}) {
    corners.Add({x, y, 0.0}, Vector3d::UnitZ());
  }
  Indices rim = OuterRim(corners.cloud, {0, 1, 2, 3, 4}, samples::LevelAt(0.0), kAlpha_m);
  std::sort(rim.begin(), rim.end());
  EXPECT_EQ(rim, (Indices{0, 1, 2, 3}));
  EXPECT_TRUE(OuterRim(corners.cloud, {}, samples::LevelAt(0.0), kAlpha_m).empty());
}

TEST(TopHeight, PassesOverFourStrayPoints) {
  Analytic shape;
  Indices points = shape.AddRectangle({0.0, 0.0, 0.05}, {0.02, 0.0, 0.0}, {0.0, 0.02, 0.0});
  for (int stray = 0; stray < 5; ++stray) {
    EXPECT_NEAR(TopHeight(shape.cloud, points, samples::LevelAt(0.0)), 0.05, 1e-12) << stray;
    points.push_back(shape.Add({0.0, 0.0, 0.06 + 0.001 * stray}, Vector3d::UnitZ()));
  }
  EXPECT_NEAR(TopHeight(shape.cloud, points, samples::LevelAt(0.0)), 0.06, 1e-12);
  EXPECT_NEAR(BaseHeight(shape.cloud, points, samples::LevelAt(0.0)), 0.05, 1e-12);
}

TEST(FindTopSurface, IsTheRimAboveTheFullerFloor) {
  Analytic bowl;
  Indices all = bowl.AddDisc({0.0, 0.0, 0.02}, 0.05);
  const Indices rim = bowl.AddDisc({0.0, 0.0, 0.06}, 0.06, 0.052);
  all = samples::Joined(all, rim);
  base::Rng rng(1);
  FeatureOptions options;
  const auto top = FindTopSurface(Given(bowl.cloud, options).Context(), all, rng);
  ASSERT_TRUE(top);
  EXPECT_EQ(top->points, rim);
  EXPECT_NEAR(top->center_C.head<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(top->major_m, 0.12, 0.001);
  options.top_plane_share = 1.0;  // as published
  const auto published = FindTopSurface(Given(bowl.cloud, options).Context(), all, rng);
  ASSERT_TRUE(published);
  EXPECT_NEAR(published->center_C.z(), 0.02, 1e-9);
}

// A lip with a notch. Its rim enters at the notch and returns along the inside; the bridged rim
// runs only along the outside.
TEST(FindTopSurface, HasABridgedRimWhereThatIsAskedFor) {
  Analytic lip;
  Indices all = lip.AddDisc({0.0, 0.0, 0.06}, 0.06, 0.050);
  std::erase_if(all, [&](auto i) {
    const Vector3d& p = lip.cloud.points[i];
    return p.x() > 0.0 && std::abs(p.y()) < 0.01;
  });
  FeatureOptions options;
  const auto find = [&](bool bridged_rims) {
    base::Rng rng(1);
    options.bridged_rims = bridged_rims;
    return FindTopSurface(Given(lip.cloud, options).Context(), all, rng);
  };
  const auto top = find(true);
  ASSERT_TRUE(top);
  const auto innermost = [&](const Indices& rim) {
    double least_m = 1.0;
    for (const auto i : rim) least_m = std::min(least_m, lip.cloud.points[i].head<2>().norm());
    return least_m;
  };
  EXPECT_LT(innermost(top->rim), 0.053);
  EXPECT_GT(innermost(top->bridged_rim), 0.0595 * std::cos(0.2)) << "a chord over the notch";
  const auto without = find(false);
  ASSERT_TRUE(without);
  EXPECT_EQ(without->rim, top->rim);
  EXPECT_TRUE(without->bridged_rim.empty());
}

/// A top with 300 points whose rim is an ellipse; the nearest rim point is 30 mm from the center.
struct Cup {
  Analytic shape;
  TopSurface top;
  Indices points;

  Cup() {
    for (int k = 0; k < 300; ++k) {
      const double a = 2.0 * base::kPi * k / 300;
      points.push_back(shape.Add({0.04 * std::cos(a), 0.03 * std::sin(a), 0.1}, Vector3d::UnitZ()));
    }
    top.points = points;
    top.rim = points;
    top.center_C = {0.0, 0.0, 0.1};
  }
  bool IsOpenWith(const Vector3d& p, int times, const FeatureOptions& options) {
    Indices all = points;
    for (int i = 0; i < times; ++i) all.push_back(shape.Add(p, Vector3d::UnitZ()));
    return IsOpen(Given(shape.cloud, options).Context(), all, top);
  }
};

TEST(IsOpen, HasASphereOfTwoThirdsOfTheDistanceToTheNearestRimPoint) {
  Cup cup;
  EXPECT_NEAR(OpenSphereRadius(Given(cup.shape.cloud).Context(), cup.top), 0.020,
              1e-12);  // eq. 5.9
  cup.top.rim.clear();
  EXPECT_EQ(OpenSphereRadius(Given(cup.shape.cloud).Context(), cup.top), 0.0);
}

TEST(IsOpen, AsPublishedOnePointInTheSphereCloses) {
  FeatureOptions published;
  published.open_stray_share = 0.0;
  base::Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const Vector3d direction = geometry::samples::RandomDirection(rng);
    const Vector3d center(0.0, 0.0, 0.1);
    EXPECT_TRUE(Cup().IsOpenWith(center + 0.0201 * direction, 1, published));
    EXPECT_FALSE(Cup().IsOpenWith(center + 0.0199 * direction, 1, published));
  }
}

TEST(IsOpen, ForgivesTwoPercentOfTheTop) {
  EXPECT_TRUE(Cup().IsOpenWith({0.0, 0.0, 0.09}, 6, {}));
  EXPECT_FALSE(Cup().IsOpenWith({0.0, 0.0, 0.09}, 7, {}));
}

TEST(IsOpen, WithoutARimNothingIs) {
  Cup cup;
  cup.top.rim.clear();
  EXPECT_FALSE(cup.IsOpenWith({1.0, 0.0, 0.0}, 1, {}));
}

std::optional<Ridge> RidgeOf(const Analytic& shape) {
  return FindRidge(Given(shape.cloud).Context(), samples::All(shape.cloud));
}

/// A strip of a lying elliptic cylinder with half width a and half height b, along `yaw` through
/// `center`. Its normals are from `from` to `to` about the vertical.
Analytic RidgeLying(const Vector3d& center, double yaw_rad, double a, double b, double from_rad,
                    double to_rad) {
  Analytic shape;
  const Vector3d axis(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
  const Vector3d lateral(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  for (int row = -25; row <= 25; ++row) {
    for (int k = 0; k <= 60; ++k) {
      const double t = from_rad + (to_rad - from_rad) * k / 60;
      shape.Add(center + 0.002 * row * axis + a * std::sin(t) * lateral +
                    b * std::cos(t) * Vector3d::UnitZ(),
                b * std::sin(t) * lateral + a * std::cos(t) * Vector3d::UnitZ());
    }
  }
  return shape;
}

TEST(FindRidge, IsTheHighestLineOfALyingCylinderSeenFromAnySide) {
  base::Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const double radius = rng.Uniform(0.02, 0.05);
    const double yaw = rng.Uniform(0.0, 2.0 * base::kPi);
    const double x = rng.Uniform(-0.1, 0.1);
    const Vector3d center(x, rng.Uniform(-0.1, 0.1), radius);
    // A sensor at 35 to 50 deg does not see the far side's lower part.
    const double far = rng.Uniform(0.6, 0.9);
    const auto ridge = RidgeOf(RidgeLying(center, yaw, radius, radius, -1.1, far));
    ASSERT_TRUE(ridge) << i;
    const Vector3d axis(std::cos(yaw), std::sin(yaw), 0.0);
    EXPECT_NEAR(std::abs(ridge->axis.dot(axis)), 1.0, 1e-9);
    EXPECT_NEAR(ridge->normal.z(), 1.0, 1e-9);
    EXPECT_NEAR((ridge->point - center).cross(axis).dot(Vector3d::UnitZ()), 0.0, 1e-9);
    // The height is the 80 % quantile of the strip's heights: at 0.35 / 5 rad from the ridge,
    // within one sampling step (2 rad / 60).
    EXPECT_LE(ridge->point.z(), 2.0 * radius);
    EXPECT_GE(ridge->point.z(), radius + radius * std::cos(0.07 + 0.034));
  }
}

TEST(FindRidge, IsTheFoldOfAFlatRoof) {
  Analytic roof;
  const double c = std::cos(base::Deg(15.0));
  const double s = std::sin(base::Deg(15.0));
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= 50; ++i) {
      for (int k = 0; k < 15; ++k) {
        const double d = 0.001 + 0.002 * k;
        roof.Add({0.002 * i, 0.03 + side * c * d, 0.08 - s * d}, {0.0, side * s, c});
      }
    }
  }
  const auto ridge = RidgeOf(roof);
  ASSERT_TRUE(ridge);
  EXPECT_NEAR(std::abs(ridge->axis.x()), 1.0, 1e-9);
  EXPECT_NEAR(ridge->point.y(), 0.03, 1e-9);
}

TEST(FindRidge, RefusesPlanesSpheresAndFlatArcs) {
  Analytic plane;
  plane.AddRectangle({0.0, 0.0, 0.05}, {0.05, 0.0, 0.0}, {0.0, 0.03, 0.0});
  EXPECT_FALSE(RidgeOf(plane));

  Analytic sphere;
  base::Rng rng(2);
  for (int i = 0; i < 3000; ++i) {
    Vector3d n = geometry::samples::RandomDirection(rng);
    n.z() = std::abs(n.z());
    sphere.Add(Vector3d(0.0, 0.0, 0.05) + 0.04 * n, n);
  }
  EXPECT_FALSE(RidgeOf(sphere));

  // Normals are within 10 deg of the vertical; the middle 60 % of them spread over 12 deg.
  EXPECT_FALSE(RidgeOf(RidgeLying({0.0, 0.0, 0.0}, 0.3, 0.2, 0.2, -0.17, 0.17)));
}

TEST(FindRidge, RefusesTheNearLipAndTheFarWallOfACup) {
  // Both face the sensor on either side, and so do both ends of their normals' spread.
  Analytic cup;
  for (const double y : {-0.04, 0.04}) {
    for (int i = -20; i <= 20; ++i) {
      for (int k = 0; k <= 30; ++k) {
        const double t = -0.9 + 1.8 * k / 30;
        cup.Add({0.002 * i, y + 0.001 * (k % 3), 0.08}, {0.0, std::sin(t), std::cos(t)});
      }
    }
  }
  EXPECT_FALSE(RidgeOf(cup));
}

/// A point in a row across a body about the x axis, and the rotation of its normal about that axis.
struct Spot {
  double turn_rad;
  double offset_m;
  double height_m;
};

constexpr double kRidgeRadius_m = 0.04;
constexpr double kStrip_rad = 0.1;  ///< turn of points next to the ridge
constexpr double kFlank_rad = 0.6;  ///< turn of points far from it

Spot OnCircle(double turn_rad) {
  return {turn_rad, kRidgeRadius_m * std::sin(turn_rad), 0.1 + kRidgeRadius_m * std::cos(turn_rad)};
}

/// @param along  share of the normal along the axis
void AddSpot(Analytic& shape, int row, const Spot& spot, double along = 0.0) {
  shape.Add({0.002 * row, spot.offset_m, spot.height_m},
            along * Vector3d::UnitX() +
                std::sqrt(1.0 - along * along) *
                    Vector3d(0.0, std::sin(spot.turn_rad), std::cos(spot.turn_rad)));
}

/// A row with a point on each flank and one on the ridge's strip, on alternating sides.
void AddThree(Analytic& shape, int row, double strip_rad, const Spot& flank) {
  AddSpot(shape, row, {-flank.turn_rad, -flank.offset_m, flank.height_m});
  AddSpot(shape, row, OnCircle(row % 2 == 0 ? strip_rad : -strip_rad));
  AddSpot(shape, row, flank);
}

Analytic Threes(int rows, double strip_rad, const Spot& flank) {
  Analytic shape;
  for (int row = 0; row < rows; ++row) AddThree(shape, row, strip_rad, flank);
  return shape;
}

/// 100 rows with normals up to `wide_rad` on both sides. In the first `tilted` rows, normals have a
/// component along the axis, alternating forwards and backwards.
Analytic Tilted(double wide_rad, int tilted, double along) {
  Analytic shape;
  for (int row = 0; row < 100; ++row) {
    const double share = row >= tilted ? 0.0 : row % 2 == 0 ? along : -along;
    for (int k = -150; k <= 150; ++k) AddSpot(shape, row, OnCircle(wide_rad * k / 150), share);
  }
  return shape;
}

TEST(UpwardPoints, AreThoseWithinTheAngle) {
  Analytic shape;
  base::Rng rng(3);
  geometry::Indices segment, upward;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const double from_up = rng.Uniform(0.0, base::kPi);
    const double turn = rng.Uniform(0.0, 2.0 * base::kPi);
    shape.Add(Vector3d::Zero(), {std::sin(from_up) * std::cos(turn),
                                 std::sin(from_up) * std::sin(turn), std::cos(from_up)});
    if (i % 3 == 0) continue;
    segment.push_back(i);
    if (from_up <= 1.2) upward.push_back(i);
  }
  EXPECT_EQ(UpwardPoints(shape.cloud, segment, Vector3d::UnitZ(), 1.2), upward);
}

TEST(FindRidge, NeedsTwiceThePointsOfASurface) {
  Analytic shape;
  for (int row = 0; row < 4; ++row) {
    for (const double turn : {-0.6, -0.3, -0.1, 0.1, 0.3, 0.6}) {
      AddSpot(shape, row, OnCircle(turn));
    }
  }
  EXPECT_TRUE(RidgeOf(shape));  // 24: two surfaces of 12
  shape.cloud.points.pop_back();
  shape.cloud.normals.pop_back();
  EXPECT_FALSE(RidgeOf(shape));
}

TEST(FindRidge, LooksAtNormalsInItsWindow) {
  // Without the flanks there are 16 points, which is too few.
  for (const double turn : {1.14, 1.16}) {  // the window is 1.15
    Analytic shape;
    for (int row = 0; row < 4; ++row) {
      for (const double t : {-turn, -0.3, -0.1, 0.1, 0.3, turn}) AddSpot(shape, row, OnCircle(t));
    }
    EXPECT_EQ(RidgeOf(shape).has_value(), turn < 1.15) << turn;
  }
}

TEST(FindRidge, LeavesOutEndFacesOfLessThanAFifth) {
  // They alternate forwards and backwards, so the axis of all normals is the body's axis.
  EXPECT_TRUE(RidgeOf(Tilted(0.8, 18, 0.8)));
  EXPECT_FALSE(RidgeOf(Tilted(0.8, 22, 0.8)));
  // A normal counts as an end face from 0.35 along the axis; three tenths are too many.
  EXPECT_TRUE(RidgeOf(Tilted(0.8, 30, 0.34)));
  EXPECT_FALSE(RidgeOf(Tilted(0.8, 30, 0.36)));
}

TEST(FindRidge, HasTheAxisOfTheBodyWithoutItsEndFace) {
  Analytic shape = Tilted(0.8, 0, 0.0);
  for (int k = 0; k < 3000; ++k) {  // a tenth, towards one end
    AddSpot(shape, 100 + k % 5, {0.0, 0.0, 0.1 + kRidgeRadius_m}, 0.8);
  }
  const auto ridge = RidgeOf(shape);
  ASSERT_TRUE(ridge);
  EXPECT_NEAR(std::abs(ridge->axis.x()), 1.0, 1e-9);
}

TEST(FindRidge, NeedsNormalsThatAreSquareToItsAxisInTheMean) {
  // All normals have the same squared component along the axis, so this is the mean; the limit is
  // 0.045.
  EXPECT_TRUE(RidgeOf(Tilted(0.8, 100, std::sqrt(0.044))));
  EXPECT_FALSE(RidgeOf(Tilted(0.8, 100, std::sqrt(0.046))));
}

TEST(FindRidge, LeansLessThan30Deg) {
  for (const double lean : {29.0, -29.0, 31.0, -31.0}) {
    Analytic shape = Tilted(0.9, 0, 0.0);
    shape.Turn(Eigen::AngleAxisd(base::Deg(lean), Vector3d::UnitY()));
    EXPECT_EQ(RidgeOf(shape).has_value(), std::abs(lean) < 30.0) << lean;
  }
}

TEST(FindRidge, NeedsNormalsThatSpread) {
  // The middle 60 % of uniform turns between -w and w spread over 1.2 w, within a step of w / 150.
  // At least 0.44 rad is required.
  EXPECT_TRUE(RidgeOf(Tilted(0.45 / 1.2, 0, 0.0)));
  EXPECT_FALSE(RidgeOf(Tilted(0.43 / 1.2, 0, 0.0)));
}

TEST(FindRidge, FacesTheSidesThatItsPointsAreOn) {
  // With a share p of points on the wrong side, sine and offset correlate by 1 - 2 p (both are
  // symmetric about 0). At least 0.7 is required.
  for (const int wrong : {7, 8}) {
    Analytic shape;
    for (int row = 0; row < 50; ++row) {
      for (int k = -30; k <= 30; ++k) {
        Spot spot = OnCircle(k / 30.0);
        if ((row * 7) % 50 < wrong) spot.offset_m = -spot.offset_m;
        AddSpot(shape, row, spot);
      }
    }
    EXPECT_EQ(RidgeOf(shape).has_value(), wrong == 7) << wrong;
  }
}

TEST(FindRidge, NeedsASurfacesPointsInItsStrip) {
  const Spot flank = OnCircle(kFlank_rad);
  EXPECT_TRUE(RidgeOf(Threes(12, kStrip_rad, flank)));
  EXPECT_FALSE(RidgeOf(Threes(11, kStrip_rad, flank)));
  // The strip's normals are within 0.35 rad of the ridge's.
  EXPECT_TRUE(RidgeOf(Threes(40, 0.34, flank)));
  EXPECT_FALSE(RidgeOf(Threes(40, 0.36, flank)));
}

/// 200 rows of flanks; the middle `strip_rows` of them also have a strip.
Analytic ShortRidge(int strip_rows) {
  Analytic shape;
  const Spot flank = OnCircle(kFlank_rad);
  for (int row = -100; row < 100; ++row) {
    if (row >= -strip_rows / 2 && row < strip_rows / 2) {
      AddThree(shape, row, kStrip_rad, flank);
    } else {
      AddSpot(shape, row, {-kFlank_rad, -flank.offset_m, flank.height_m});
      AddSpot(shape, row, flank);
    }
  }
  return shape;
}

TEST(FindRidge, IsAsLongAsMostOfTheBody) {
  // If a strip covers the share f of the rows, 0.9 f lie between its quantiles. Between the body's
  // quantiles lie 1 - 0.05 (2 + f), since a twentieth of its points is that share of the two-point
  // rows at an end. f = 0.59 gives 0.61 and f = 0.57 gives 0.589; 0.6 is required. A row is 0.006.
  EXPECT_TRUE(RidgeOf(ShortRidge(118)));
  EXPECT_FALSE(RidgeOf(ShortRidge(114)));
}

TEST(FindRidge, IsNotLongerForStrayPoints) {
  Analytic shape = ShortRidge(100);
  for (const int row : {-100, -99, 98, 99}) AddSpot(shape, row, OnCircle(kStrip_rad));
  EXPECT_FALSE(RidgeOf(shape));
}

/// Drop of the flank points below the strip, as a share of the drop of a circle with radius 1.
double FlankDrop() {
  return (std::cos(kStrip_rad) - std::cos(kFlank_rad)) / (1.0 - std::cos(kFlank_rad));
}

/// A flank at `offset_m` that drops by `drop` of the drop of kRidgeRadius_m's circle.
Spot FlankDownBy(double drop, double offset_m) {
  Spot flank = OnCircle(kStrip_rad);
  flank.height_m -= drop * kRidgeRadius_m * (std::cos(kStrip_rad) - std::cos(kFlank_rad));
  return {kFlank_rad, offset_m, flank.height_m};
}

TEST(FindRidge, ComesDownByAShareOfACirclesDrop) {
  constexpr double kAsked = 0.35;
  // Narrower than the circle of its normals: a circle of its half width counts.
  const double half_width = kRidgeRadius_m * std::sin(kFlank_rad);
  const double narrow = kAsked / FlankDrop() * std::sin(kFlank_rad);
  EXPECT_TRUE(RidgeOf(Threes(40, kStrip_rad, FlankDownBy(1.02 * narrow, half_width))));
  EXPECT_FALSE(RidgeOf(Threes(40, kStrip_rad, FlankDownBy(0.98 * narrow, half_width))));
  // Wider: the circle of the strip's curvature counts.
  const double wide = kAsked / FlankDrop();
  EXPECT_TRUE(RidgeOf(Threes(40, kStrip_rad, FlankDownBy(1.02 * wide, 1.5 * kRidgeRadius_m))));
  EXPECT_FALSE(RidgeOf(Threes(40, kStrip_rad, FlankDownBy(0.98 * wide, 1.5 * kRidgeRadius_m))));
}

TEST(FindRidge, IsNotWiderForStrayPoints) {
  const double narrow = 0.35 / FlankDrop() * std::sin(kFlank_rad);
  const Spot flank = FlankDownBy(1.1 * narrow, kRidgeRadius_m * std::sin(kFlank_rad));
  Analytic shape = Threes(400, kStrip_rad, flank);
  for (int row = 0; row < 12; ++row) {  // 1 % on each side
    AddSpot(shape, row, {kFlank_rad, 1.2 * kRidgeRadius_m, flank.height_m});
    AddSpot(shape, row, {-kFlank_rad, -1.2 * kRidgeRadius_m, flank.height_m});
  }
  EXPECT_TRUE(RidgeOf(shape));
}

TEST(FindRidge, AsksForNoDropNextToTheRidge) {
  // Flanks without any drop, just within and just beyond 0.45 rad.
  for (const double turn : {0.44, 0.46}) {
    const Spot flank{turn, kRidgeRadius_m * std::sin(turn), OnCircle(kStrip_rad).height_m};
    EXPECT_EQ(RidgeOf(Threes(40, kStrip_rad, flank)).has_value(), turn < 0.45) << turn;
  }
}

TEST(FindRidge, IsAtTheHeightThatAFifthOfItsStripIsAbove) {
  for (const int high : {19, 21}) {
    Analytic shape;
    for (int row = 0; row < 100; ++row) {
      AddThree(shape, row, kStrip_rad, OnCircle(kFlank_rad));
      if ((row * 7) % 100 < high) shape.cloud.points[shape.cloud.size() - 2].z() += 0.003;
    }
    const auto ridge = RidgeOf(shape);
    ASSERT_TRUE(ridge);
    const double height = OnCircle(kStrip_rad).height_m + (high < 20 ? 0.0 : 0.003);
    EXPECT_NEAR(ridge->point.z(), height, 1e-9) << high;
  }
}

TEST(FindRidge, IsInTheMiddleOfAStripWithoutCurvature) {
  Analytic shape;
  for (int row = 0; row < 40; ++row) {
    for (const double offset : {-0.002, 0.006}) AddSpot(shape, row, {0.0, offset, 0.14});
    for (const double side : {-1.0, 1.0}) {
      AddSpot(shape, row, {side * kFlank_rad, side * 0.02, 0.13});
    }
  }
  const auto ridge = RidgeOf(shape);
  ASSERT_TRUE(ridge);
  EXPECT_NEAR(ridge->point.y(), 0.002, 1e-9);
  EXPECT_NEAR(ridge->point.z(), 0.14, 1e-9);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
